/**
 * @file  sim_host/fmu/instance.h
 * @brief An FMU as the files of this folder share it: fmi.c has the functions of FMI 3.0, setup.c reads what it is,
 *        drive.c and plant.c are the two kinds.
 *
 * The file resources/setup.txt has a line per item, words apart by spaces; lines of variables are numbered from 0, which is their
 * value reference; the next number is the independent variable time.
 *
 *     kind drive|plant                 seed N
 *     model NAME VALUE                 a number of the machine, fixed
 *     param NAME VALUE                 a parameter of the drive, tunable
 *     effect EFFECT NAME VALUE         a parameter of an effect, fixed
 *     input NAME VALUE                 start value
 *     output NAME
 */
#ifndef SIM_HOST_FMU_INSTANCE_H
#define SIM_HOST_FMU_INSTANCE_H

#include <stdbool.h>
#include <stdint.h>

#include "sim_host/fmu/fmi3/fmi3FunctionTypes.h"
#include "sim_host/capi/evenspin_capi.h"
#include "sim_host/plant/plant.h"

#define FMU_NAME 64

typedef enum { FMU_MODEL, FMU_PARAM, FMU_EFFECT, FMU_INPUT, FMU_OUTPUT } fmu_role_t;

typedef struct {
    fmu_role_t role;
    char       name[FMU_NAME];
    char       other[FMU_NAME]; /**< Of an effect's parameter: the effect. */
    double     value, start;    /**< Of an output: not used. */
    bool       pending;         /**< A parameter that the drive has not taken yet. */
    int        plant_index;     /**< plant.c: which of its inputs or outputs. */
} fmu_variable_t;

typedef struct fmu fmu_t;

/** What a kind of FMU does. Each returns false after a message. */
typedef struct {
    bool (*start)(fmu_t *fmu);
    bool (*set)(fmu_t *fmu, fmu_variable_t *variable); /**< A new value while it runs. */
    bool (*run)(fmu_t *fmu, int64_t periods);
    double (*get)(fmu_t *fmu, const fmu_variable_t *variable); /**< An output. */
    void (*stop)(fmu_t *fmu);
} fmu_kind_t;

typedef enum { FMU_INSTANTIATED, FMU_INITIALIZING, FMU_STEPPING, FMU_TERMINATED } fmu_mode_t;

struct fmu {
    const fmu_kind_t       *kind;
    fmu_variable_t         *variable;
    int                     count, room;
    uint64_t                seed;
    fmu_mode_t              mode;
    double                  start_s, period_s;
    int64_t                 periods; /**< Done since the start. */
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback  log;
    es_sim_t               *sim;   /**< drive.c */
    sim_plant_t             plant; /**< plant.c */
    sim_model_t             model;
    double                  effect[SIM_EFFECTS_MAX][SIM_EFFECT_PARAMS];
    sim_reading_t           reading;
};

extern const fmu_kind_t fmu_drive, fmu_plant;

/** setup.c: read resources/setup.txt; false after a message. */
bool fmu_read_setup(fmu_t *fmu, const char *resource_path);
/** instance.c: a message to the importer; always false, so that it can be returned. */
bool fmu_refuse(const fmu_t *fmu, const char *format, ...);

#endif
