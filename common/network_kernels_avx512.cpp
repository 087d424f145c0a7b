#define EVOGRASP_WIDTH 16
#define EVOGRASP_KERNELS kAvx512
#define EVOGRASP_KERNELS_NAME "avx512"
#include "common/network_kernels.inc"
