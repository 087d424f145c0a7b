#define EVOGRASP_WIDTH 16
#define EVOGRASP_KERNELS kAvx512
#include "common/network_kernels.inc"
