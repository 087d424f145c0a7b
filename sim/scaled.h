// Objects of another size and weight than they were modelled with.
#pragma once

#include "proto/bundle.pb.h"

namespace evograsp::sim {

// The object `size` times as large about its origin, of the same shape and `density` times the density: mass
// goes with size^3, inertia with size^5. For pictures and lift tests; trials scale in place (world.h).
proto::ObjectBundle scaled(proto::ObjectBundle object, double size, double density = 1);

}  // namespace evograsp::sim
