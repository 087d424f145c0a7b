// Two meshes of our own making, for configurations that learn on mesh files: configs/objects/bottle.obj and
// cup.obj are what these functions return.
#pragma once

#include <string>

namespace evograsp::assets {

// Wavefront OBJ text, metres, standing on z = 0. One closed shell: body, shoulder and neck of a full
// bottle, 16.5 cm.
std::string bottle_obj();
// A cup 8.6 cm tall whose handle is a second closed shell with its ends inside the wall.
std::string handled_cup_obj();

}  // namespace evograsp::assets
