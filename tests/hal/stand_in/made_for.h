/* For which machine an object was made: cl2000 of this folder refuses a link of objects that disagree. */
static const char made_for[] __attribute__((section(".made_for"), used)) = MADE_FOR;
