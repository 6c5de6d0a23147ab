#include "viewer_files.h"

#include <algorithm>
#include <array>

#define XXH_INLINE_ALL
#include <fmt/format.h>
#include <xxhash.h>

extern "C" {
extern const char palpate_viewer_page_begin[], palpate_viewer_page_end[];
extern const char palpate_viewer_script_begin[], palpate_viewer_script_end[];
extern const char palpate_viewer_style_begin[], palpate_viewer_style_end[];
extern const char palpate_viewer_icon_begin[], palpate_viewer_icon_end[];
extern const char palpate_viewer_licences_begin[], palpate_viewer_licences_end[];
}

namespace palpate::cli {

const WebFile* viewer_file(std::string_view path) {
  const auto file = [](const char* path_on_server, const char* type, const char* begin, const char* end) {
    const std::string_view bytes(begin, static_cast<std::size_t>(end - begin));
    return WebFile{path_on_server, type, bytes,
                   fmt::format("{:016x}", XXH3_64bits(bytes.data(), bytes.size()))};
  };
  static const std::array<WebFile, 5> files{
      file("/", "text/html; charset=utf-8", palpate_viewer_page_begin, palpate_viewer_page_end),
      file("/viewer.js", "text/javascript; charset=utf-8", palpate_viewer_script_begin,
           palpate_viewer_script_end),
      file("/viewer.css", "text/css; charset=utf-8", palpate_viewer_style_begin, palpate_viewer_style_end),
      file("/icon.svg", "image/svg+xml", palpate_viewer_icon_begin, palpate_viewer_icon_end),
      file("/licences.txt", "text/plain; charset=utf-8", palpate_viewer_licences_begin,
           palpate_viewer_licences_end)};
  const auto at = std::find_if(files.begin(), files.end(), [&](const WebFile& f) { return f.path == path; });
  return at == files.end() ? nullptr : at;
}

}  // namespace palpate::cli
