// Which instruction set the wide inner loops use. They give equal bits in all of them, so this is about time
// only.
#pragma once

namespace evograsp {

enum class Isa { kBaseline, kAvx2, kAvx512 };

const char* name(Isa isa);
// True if this machine can run it. kAvx512: the F and DQ parts.
bool runs_here(Isa isa);
// The widest that runs here.
Isa active_isa();
// Makes active_isa() answer `isa`: for tests and benchmarks, not while another thread computes.
void force_isa(Isa isa);

}  // namespace evograsp
