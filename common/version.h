#pragma once

namespace evograsp {

inline constexpr char kVersion[] = "0.1.0";
// Of proto/wire.proto: a peer that speaks another is refused with a reason.
inline constexpr unsigned kProtocolVersion = 3;
// Bumped with every change that alters a single bit of any measurement: part of the experiment fingerprint.
inline constexpr int kTrialVersion = 1;

}  // namespace evograsp
