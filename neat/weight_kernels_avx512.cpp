#define EVOGRASP_WIDTH 16
#define EVOGRASP_KERNELS kAvx512Weights
#include "neat/weight_kernels.inc"
