// XML text reduced to what every parser reads alike, before a recursive one sees it.
#pragma once

#include <string>
#include <string_view>

#include "common/result.h"

namespace evograsp::assets {

inline constexpr int kMaxXmlDepth = 64;
inline constexpr int kMaxXmlElements = 20'000;
inline constexpr int kMaxXmlAttributes = 64;  // of one element; TinyXML compares each with all before it

// The elements and their text, without byte order mark, comments, processing instructions (<? ?>), a DOCTYPE
// and what stands after a NUL. An error names the line when elements are nested too deep, too many, closed
// without having been opened, or cut short, and when a construct is one that parsers may end at different
// places: a CDATA section, an internal DTD, a '<' that begins no tag.
Result<std::string> plain_xml(std::string_view xml);

}  // namespace evograsp::assets
