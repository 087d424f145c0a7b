#define EVOGRASP_WIDTH 8
#define EVOGRASP_KERNELS kAvx2
#define EVOGRASP_KERNELS_NAME "avx2"
#include "common/network_kernels.inc"
