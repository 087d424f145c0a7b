// The same bytes for the same input: twice in a process, in every build, on every machine. A run's
// fingerprint leans on it. A changed hash here means that every stored run and champion was made with other
// shapes: change it knowingly.
#include <gtest/gtest.h>

#include "assets/assets.h"
#include "tests/assets/files.h"

namespace evograsp::assets {
namespace {

struct Golden {
  const char* name;
  const char* id;
};

constexpr Golden kObjects[] = {
    {"ball", "0c267da57d487270564ee60c13a8579f7f10906f52fe898ea31b80d16e7508f7"},
    {"bar", "40f2c882159537b84422e63faf1e2470aef5bc3695e69ab0acfe33f50e83478e"},
    {"beaker", "9ce024ffded031816d466cd1ec7c5b1ad2ffa9cd229e2c2a4d41fe6c04a33bbf"},
    {"big_ball", "0bfe6655b3cfd2597ecbbc3bff5cc5032106d0b28a118beebc05a18bab7864a0"},
    {"block", "6b669fab08e509fc841be1860dc061741858f9423a5c53239e95e41729f41f27"},
    {"bottle", "3eb233ab38ba89dea5dc1e77050842046ebb4ef4d1dde03ebcb84d67bc889957"},
    {"brick", "5160600d268f7e9c93c82d247b45a73dab1a79ab98b9336175e5fb975e3f2054"},
    {"can", "f4dc97ff5af402e7dd8fb12ac1193e51f07b1b8b3061b9771f6493e3cbae794e"},
    {"carton", "029cfa289106c284b85fe01adf1ee27f97534a0544ec8e7382c844083ccbe273"},
    {"cube_5cm", "7cc011cf6d87d6a883b6f30ef5e736334b7cf978e7c1801052fab0cd8f46f6ed"},
    {"cube_6cm", "cae87edec548c90b1cc86f71cf4f7d76e7dcb126cf7245d803c3542caab0b83b"},
    {"cube_8cm", "798c1e0b47c5216e6ec38824b52b4fedcf69dd7ed776a45a3fa8ae4c8aef6587"},
    {"cuboid", "926a11a510eea75c8006fb99f44240e3d4dd04abb14b21fd0e6351080daadd86"},
    {"cup", "8b05c4b747af50dd3f0a8677a98fc2d7dd601ffe87b6ee0a88424a21addbd4b0"},
    {"cylinder", "2c00b2718a91f2ce475b874a09380f4f8e44dc3f97b36bc1c1515d544382f51e"},
    {"die", "d5e3adfa7e0e18d5617dd11f840a9c85b7886d98ac71e23bd38e7de2736ff33f"},
    {"disc", "653d7f2c10b4aea7ccdaf5a6fe683dded14c4c7b5355fb6e4220f42df5c99c36"},
    {"drum", "d7cd07fb47fc9c40bea894ad0bab5ce09f9e4e07a415ce2b6ce659a064e40f6b"},
    {"flask", "357462a7b702112c570dc1770bf7e1fd639dae6d08012d0943f384e030eb8f9f"},
    {"jar", "ef3a5aa7875ee44b1a2f5432522f76b27fc8d5f8f8797e6d47ed11921e5ed892"},
    {"mug", "6ecec8d3abbf113686a350fa2946964c012906daf90780d4e5a4a5ecf1f1b285"},
    {"plank", "04b98c9db33ff81f92af3f1636c9bfa5608889114c001bc17bd3f0396a561e9b"},
    {"plated_mug", "44b8de769317e7d30621590001d1dde14a39e8b8b88a4828c9be91794ac30441"},
    {"puck", "96671533f63cbd2f7cc346d30ee1c7e961848c2c1843a7d10646dc38651e8553"},
    {"roll", "afc26dfb8ac76024f5e4caa0d05b48761c0e3ec3d4612840ac1ab812396421aa"},
    {"slab", "bf667f1d59c946ff14ce207a9d64a356dccbbac990d67ad37983395fa5c833fa"},
    {"sphere_3cm", "b89478613a28bd1c8b761a2269b44684167aea000aefe62a44b07e4bde7fcc5a"},
    {"sphere_4cm", "ae208beb077587b291ae1ce8df50dde89c34d077648445686bd264726c6dce83"},
    {"stick", "0b3316c76c2fc770adf1a32b54de3abd91d77976e5270d313a1b757c7c99d0a5"},
    {"tipped_bottle", "1d57d90311954332abfdc699c489691b494d5baf7f2977f24befe3ea7b2f9018"},
    {"tipped_mug", "13159334dc60425147e192df9abc1f4738f36515f2a4bdabd55d9beb5cbf63a0"},
    {"tube", "f1bbae397cbd56d8dc49d9bd257fc152cb475ff87d511898fe4b230622846c45"},
};
constexpr Golden kHands[] = {
    {"barrett", "50d501f2c4108d8c944a3d6b398d60d6a5789731e4c183f55ce81a63073fac8e"},
    {"meka_h2", "2a6a03c3a5f9a66e12f39b7f0e8adf801374f6f5d54429c823e4588c5986e3d1"},
    {"parallel_jaw", "bcc7ec176d39ea3f0f109344b0a23874fa21b9f636bddd48246e46e86658029e"},
};

TEST(Golden, BuiltInObjectsKeepTheirIds) {
  testing::TemporaryFolder cache;
  for (const Golden& golden : kObjects) {
    for (int round = 0; round < 2; ++round) {  // the second one finds the cache filled
      const Result<LoadedObject> object = load_object(golden.name, {1, 0, {}, cache.path()});
      ASSERT_TRUE(object) << object.error().message;
      EXPECT_EQ(object->id, golden.id) << golden.name;
    }
  }
  EXPECT_EQ(std::size(kObjects), builtin_objects().size());
}

TEST(Golden, BuiltInHandsKeepTheirIds) {
  for (const Golden& golden : kHands) {
    const Result<LoadedHand> hand = load_hand(golden.name, {});
    ASSERT_TRUE(hand) << hand.error().message;
    EXPECT_EQ(hand->id, golden.id) << golden.name;
  }
  EXPECT_EQ(std::size(kHands), builtin_hands().size());
}

}  // namespace
}  // namespace evograsp::assets
