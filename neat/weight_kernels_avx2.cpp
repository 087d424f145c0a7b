#define EVOGRASP_WIDTH 8
#define EVOGRASP_KERNELS kAvx2Weights
#include "neat/weight_kernels.inc"
