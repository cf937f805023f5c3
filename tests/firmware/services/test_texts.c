/* firmware/app/doc_text.h: the firmware of the chip carries names, units and choices, and no text that explains. */
#define EVENSPIN_NO_TEXTS
#define params_info bare_params_info
#define params_default bare_params_default
#define params_get bare_params_get
#define params_set bare_params_set
#define params_only_at_rest bare_params_only_at_rest
#define params_check bare_params_check
#define faults_info bare_faults_info
#define telemetry_info bare_telemetry_info
#define telemetry_read bare_telemetry_read
#define telemetry_read_row bare_telemetry_read_row
#define schema_count bare_schema_count
#define schema_name bare_schema_name
#define schema_record bare_schema_record
#define schema_text bare_schema_text
#define schema_hash bare_schema_hash
#include "firmware/app/faults.c"
#undef TABLE
#define TABLE PARAMETER_TABLE
#include "firmware/app/parameters.c"
#undef TABLE
#define TABLE SIGNAL_TABLE
#include "firmware/app/telemetry.c"
#undef TABLE
#include "firmware/services/schema.c"
#undef schema_hash
#undef faults_info
#undef params_info

#include "unity.h"

uint32_t            schema_hash(void); /* of the firmware with texts */
const param_info_t *params_info(uint16_t index);

void setUp(void) {}
void tearDown(void) {}

void test_texts_a_firmware_without_them_answers_none(void)
{
    for (uint16_t kind = 0U; kind < (uint16_t)SCHEMA_KINDS; kind++) {
        TEST_ASSERT_NULL(bare_schema_text(kind, 1U, 0U));
    }
    /* nor is there room for a text in a row of the lists */
    TEST_ASSERT_EQUAL_size_t(sizeof(const char *), sizeof(fault_info_t));
    TEST_ASSERT_EQUAL_size_t(sizeof(const char *), sizeof(command_info_t));
    TEST_ASSERT_EQUAL_size_t(2U * sizeof(const char *), sizeof(signal_info_t));
}

/* The hash is that of names, units, choices, kinds and ranges. */
void test_texts_names_units_and_choices_stay_and_the_schema_is_the_same(void)
{
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        TEST_ASSERT_EQUAL_STRING(params_info(i)->name, bare_params_info(i)->name);
        TEST_ASSERT_EQUAL_STRING(params_info(i)->text, bare_params_info(i)->text);
    }
    TEST_ASSERT_EQUAL_HEX32(schema_hash(), bare_schema_hash());
}
