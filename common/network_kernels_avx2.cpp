#define EVOGRASP_WIDTH 8
#define EVOGRASP_KERNELS kAvx2
#include "common/network_kernels.inc"
