/* What the check must find with the sizes of the C28x, and does not find with those of the host. */
int planted(int a) { return a << 17; }
