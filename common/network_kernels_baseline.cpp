#define EVOGRASP_WIDTH 4
#define EVOGRASP_KERNELS kBaseline
#include "common/network_kernels.inc"
