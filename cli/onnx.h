// A champion's network as an ONNX model, for robot controllers that run onnxruntime, OpenCV or a like
// library.
#pragma once

#include <string>

#include "common/result.h"
#include "proto/genome.pb.h"

namespace evograsp::cli {

// IR version 8, operator set 13 (https://onnx.ai/onnx/operators): input "observation" [N, inputs], output
// "action" [N, outputs], single precision. One Gemm a depth level and activation function, not one operator a
// node. What the columns mean, and the experiment the network was evolved for, are in the model's metadata.
//
// Runtimes have exponential functions and orders of summation of their own: their answers differ from
// Network::activate() by some 1e-6. kUnsupported for recurrent networks.
Result<std::string> to_onnx(const proto::Champion& champion);

}  // namespace evograsp::cli
