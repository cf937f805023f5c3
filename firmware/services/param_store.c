#include "firmware/services/param_store.h"

#include "firmware/link/codec.h"

#define WORDS (2U * (uint16_t)PARAM_COUNT)

bool param_store_present(void) { return store_fits(WORDS, 0U); }

/* Two words a value: a float by its bits, whatever the kind of the parameter. */
static uint16_t value_word(const void *from, uint16_t i)
{
    const uint32_t bits = codec_bits(params_get((const drive_params_t *)from, i >> 1));
    return ((i & 1U) == 0U) ? (uint16_t)(bits & UINT32_C(0xFFFF)) : (uint16_t)(bits >> 16);
}

hal_status_t param_store_begin(store_t *s, const drive_params_t *params, uint32_t schema)
{
    return store_begin(s, STORE_PARAMETERS, schema, WORDS, value_word, params);
}

hal_status_t param_store_step(store_t *s)
{
    const hal_status_t status = store_step(s);
    if (status != HAL_OK) {
        return HAL_SENSOR_FAULT;
    }
    return s->active ? HAL_BUSY : HAL_OK;
}

typedef struct {
    drive_params_t *params;
    uint16_t        low;
    bool            fit;
} loading_t;

static void take_value(void *to, uint16_t i, uint16_t word)
{
    loading_t *const l = (loading_t *)to;
    l->fit = l->fit || (i == 0U);
    if ((i & 1U) == 0U) {
        l->low = word;
    } else {
        l->fit = params_set(l->params, i >> 1, codec_float(((uint32_t)word << 16) | l->low)) && l->fit;
    }
}

hal_status_t param_store_load(const store_t *s, drive_params_t *params, uint32_t schema)
{
    loading_t          loading = {params, 0U, true};
    const hal_status_t status = store_load(s, STORE_PARAMETERS, schema, WORDS, take_value, &loading);
    return ((status == HAL_OK) && !loading.fit) ? HAL_SENSOR_FAULT : status;
}
