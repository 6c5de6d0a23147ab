#include <palpate/scene/ply_rows.h>

namespace palpate {

std::unique_ptr<PlyRows> open_rows(const PlyScene& ply) {
  return ply.header.encoding == PlyEncoding::kAscii ? open_ascii_rows(ply) : open_binary_rows(ply);
}

}  // namespace palpate
