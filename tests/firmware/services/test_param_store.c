/* firmware/services/param_store.c: the old set or the new one, never a mixture, wherever the power goes. */
#include <string.h>

#include "firmware/services/param_store.h"
#include "mock_hal_storage.h"
#include "tests/firmware/support/flash.h"
#include "unity.h"

#define SCHEMA UINT32_C(0x12345678)
#define CHANGES                                                                                                                  \
    (1 + 1 + ((8 + (2 * PARAM_COUNT) + 3) / 4) + 1 + 2) /* erase, page, head and values, trailer, commit and confirm */

static store_t        store;
static drive_params_t older, newer, loaded;

/* Every value of one set differs from that of the other. */
static void fill(drive_params_t *p, float share)
{
    params_default(p);
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        const param_info_t *const info = params_info(i);
        const float               x = info->min + (share * (info->max - info->min));
        const bool                whole = info->kind != PARAM_KIND_FLOAT;
        TEST_ASSERT_TRUE(params_set(p, i, whole ? ((share < 0.5f) ? info->min : info->max) : x));
    }
}

static hal_status_t save(const drive_params_t *p)
{
    hal_status_t s = param_store_begin(&store, p, SCHEMA);
    for (int pass = 0; (pass < 100) && (s == HAL_OK) && store.active; pass++) {
        s = param_store_step(&store);
        s = (s == HAL_BUSY) ? HAL_OK : s;
    }
    return s;
}

static bool same(const drive_params_t *a, const drive_params_t *b)
{
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        if (params_get(a, i) != params_get(b, i)) {
            return false;
        }
    }
    return true;
}

static void load(void)
{
    params_default(&loaded);
    TEST_ASSERT_EQUAL_INT(HAL_OK, param_store_load(&store, &loaded, SCHEMA));
}

void setUp(void)
{
    flash_start();
    (void)memset(&store, 0, sizeof store);
    fill(&older, 0.25f);
    fill(&newer, 0.75f);
}

void tearDown(void) {}

void test_param_store_saved_set_comes_back(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(&newer));

    load();

    TEST_ASSERT_TRUE(same(&newer, &loaded));
}

void test_param_store_without_a_save_leaves_the_set_alone(void)
{
    loaded = newer;
    TEST_ASSERT_EQUAL_INT(HAL_STALE, param_store_load(&store, &loaded, SCHEMA));
    TEST_ASSERT_TRUE(same(&newer, &loaded));
}

void test_param_store_newest_of_many_saves_counts(void)
{
    for (uint16_t k = 0U; k < 20U; k++) {
        const drive_params_t *const set = ((k & 1U) == 0U) ? &newer : &older;
        TEST_ASSERT_EQUAL_INT(HAL_OK, save(set));
        load();
        TEST_ASSERT_TRUE(same(set, &loaded));
    }
}

/* At every erase and at every block, cut clean and torn. tests/firmware/storage has the rest. */
void test_param_store_power_loss_at_every_write_leaves_the_old_or_the_new_set(void)
{
    static flash_cells_t before;
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(&older));
    before = flash.cells;
    for (int32_t cut = 0; cut <= CHANGES; cut++) {
        for (uint32_t torn = 0U; torn < 2U; torn++) {
            flash.cells = before;
            store_reset(&store);
            flash.until_power_fails = cut;
            flash.torn = torn != 0U;
            (void)save(&newer);
            flash_power_up();
            store_reset(&store);

            load();

            const bool is_new = same(&newer, &loaded);
            TEST_ASSERT_TRUE_MESSAGE(is_new || same(&older, &loaded), "neither the old set nor the new one");
            TEST_ASSERT_TRUE((cut < CHANGES) || is_new);
            TEST_ASSERT_TRUE((cut > (CHANGES - 3)) || !is_new);
            TEST_ASSERT_EQUAL_INT(HAL_OK, save(&newer)); /* and saving works again */
            load();
            TEST_ASSERT_TRUE(same(&newer, &loaded));
        }
    }
}

void test_param_store_set_of_another_schema_does_not_exist(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(&newer));

    TEST_ASSERT_EQUAL_INT(HAL_STALE, param_store_load(&store, &loaded, SCHEMA ^ 1U));
    TEST_ASSERT_EQUAL_INT(HAL_STALE, param_store_load(&store, &loaded, SCHEMA ^ UINT32_C(0x80000000)));
}

void test_param_store_storage_that_refuses_fails_the_save_and_keeps_the_old_set(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(&older));
    for (int32_t n = 0; n < 60; n += 13) {
        flash.changes = 0U;
        flash.until_error = n;
        TEST_ASSERT_EQUAL_INT(HAL_SENSOR_FAULT, save(&newer));
        TEST_ASSERT_FALSE(store.active);
        load();
        TEST_ASSERT_TRUE(same(&older, &loaded));
    }
}

void test_param_store_second_save_during_a_save_is_refused(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_OK, param_store_begin(&store, &newer, SCHEMA));
    TEST_ASSERT_EQUAL_INT(HAL_BUSY, param_store_begin(&store, &older, SCHEMA));
}

void test_param_store_without_room_touches_nothing(void)
{
    flash.pages = 1U;
    TEST_ASSERT_FALSE(param_store_present());
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, save(&newer));
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, param_store_load(&store, &loaded, SCHEMA));
    TEST_ASSERT_EQUAL_UINT32(0U, flash.changes);
    flash.pages = 2U;
    TEST_ASSERT_TRUE(param_store_present());
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(&newer));
}
