/* What an FMU is: the lines of resources/setup.txt. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim_host/fmu/instance.h"

static const char *const ROLES[] = {"model", "param", "effect", "input", "output"};

static fmu_variable_t *add(fmu_t *fmu)
{
    if (fmu->count == fmu->room) {
        const int       room = (fmu->room > 0) ? 2 * fmu->room : 64;
        fmu_variable_t *more = realloc(fmu->variable, (size_t)room * sizeof *more);
        if (more == NULL) {
            return NULL;
        }
        fmu->variable = more;
        fmu->room = room;
    }
    memset(&fmu->variable[fmu->count], 0, sizeof fmu->variable[fmu->count]);
    return &fmu->variable[fmu->count++];
}

static bool read_line(fmu_t *fmu, const char *line)
{
    char      what[FMU_NAME] = "";
    char      first[FMU_NAME] = "";
    char      second[FMU_NAME] = "";
    char      third[FMU_NAME] = "";
    const int words = sscanf(line, "%63s %63s %63s %63s", what, first, second, third);
    if (words < 2) {
        return words < 1; /* an empty line */
    }
    if (strcmp(what, "kind") == 0) {
        fmu->kind = (strcmp(first, "plant") == 0) ? &fmu_plant : &fmu_drive;
        return true;
    }
    if (strcmp(what, "seed") == 0) {
        fmu->seed = strtoull(first, NULL, 10);
        return true;
    }
    for (int role = 0; role <= (int)FMU_OUTPUT; role++) {
        const int needed = (role == (int)FMU_EFFECT) ? 4 : ((role == (int)FMU_OUTPUT) ? 2 : 3);
        if (strcmp(what, ROLES[role]) == 0) {
            fmu_variable_t *const v = (words >= needed) ? add(fmu) : NULL;
            if (v == NULL) {
                return false;
            }
            v->role = (fmu_role_t)role;
            (void)snprintf(v->name, sizeof v->name, "%s", (role == (int)FMU_EFFECT) ? second : first);
            (void)snprintf(v->other, sizeof v->other, "%s", (role == (int)FMU_EFFECT) ? first : "");
            v->start = (role == (int)FMU_OUTPUT) ? 0.0 : strtod((role == (int)FMU_EFFECT) ? third : second, NULL);
            v->value = v->start;
            return true;
        }
    }
    return false;
}

bool fmu_read_setup(fmu_t *fmu, const char *resource_path)
{
    char      place[4096];
    const int length = snprintf(place, sizeof place, "%s/setup.txt", (resource_path != NULL) ? resource_path : "");
    FILE     *file = ((length > 0) && ((size_t)length < sizeof place)) ? fopen(place, "r") : NULL;
    if (file == NULL) {
        return fmu_refuse(fmu, "%s/setup.txt cannot be read: unpack the whole FMU", (resource_path != NULL) ? resource_path : "");
    }
    char line[4 * FMU_NAME];
    int  number = 0;
    bool good = true;
    while (good && (fgets(line, sizeof line, file) != NULL)) {
        number++;
        good = read_line(fmu, line);
    }
    (void)fclose(file);
    return (good && (fmu->kind != NULL)) || fmu_refuse(fmu, "setup.txt:%d: is not what `evenspin export fmu` writes", number);
}
