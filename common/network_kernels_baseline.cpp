#define EVOGRASP_WIDTH 4
#define EVOGRASP_KERNELS kBaseline
#define EVOGRASP_KERNELS_NAME "baseline"
#include "common/network_kernels.inc"
