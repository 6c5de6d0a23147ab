/// \file
/// The viewer, which is part of the program.
#pragma once

#include <string>
#include <string_view>

namespace palpate::cli {

/// A file that the viewer's page loads.
struct ViewerFile {
  std::string_view path;  ///< on the server
  std::string_view type;  ///< of its content
  std::string_view bytes;
  std::string tag;  ///< of these bytes
};

/// The file of that path; null if the viewer has none.
const ViewerFile* viewer_file(std::string_view path);

}  // namespace palpate::cli
