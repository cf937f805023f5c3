#include "hal/hal_order.h"

#include "hal/f28379d/port.h"

#if !defined(__GNUC__)
/* Empty on purpose: who calls it has to assume that it reads and writes everything. */
PORT_RAM_CODE void hal_order(void) {}
#endif
