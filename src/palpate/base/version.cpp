#include <palpate/base/version.h>

namespace palpate {

std::string_view version() { return PALPATE_VERSION; }

}  // namespace palpate
