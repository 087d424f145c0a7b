#define EVOGRASP_WIDTH 4
#define EVOGRASP_KERNELS kBaselineWeights
#include "neat/weight_kernels.inc"
