// A network as it travels to workers: the fewest bytes that give back the same bits.
//
// Of a link, NEAT's networks hold little but the weight, and of a weight little but its mantissa: 23 random
// bits and a sign. Those travel as they are. Exponents, activations, the number of links of each node and the
// distance of each source from the one before (1, mostly, where layers are dense) repeat themselves and go
// through zstd. So a link takes about 3.5 bytes instead of the 6 to 7 of proto::Network. Another network of
// the population, as a dictionary, would not help: mutation gives nearly every weight new bits.
#pragma once

#include <string>
#include <string_view>

#include "common/network.h"
#include "common/result.h"
#include "proto/genome.pb.h"

namespace evograsp {

// network: sound, as Network::to_proto() writes it.
std::string pack_network(const proto::Network& network);
// The same of a serialised proto::Network, checked: kInvalid when it is not sound.
Result<std::string> pack_serialised(const std::string& network);
// Checks everything, allocates no more than a few times what Network allows; kInvalid says what is wrong.
Result<Network> unpack_network(std::string_view bytes);

}  // namespace evograsp
