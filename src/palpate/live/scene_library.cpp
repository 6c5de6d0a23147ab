#include <palpate/live/scene_library.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <palpate/scene/scene_reader.h>

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr int kDeepest = 1;  // levels of folders below a configured one
constexpr const char* kBuiltIn = "built-in";
constexpr const char* kFirst = "first";
constexpr std::array<std::string_view, 2> kReadable{".ply", ".splat"};
/// Extensions of other scene and model formats, which converters read.
constexpr std::array<std::string_view, 8> kForeign{".spz",  ".sog", ".ksplat", ".glb",
                                                   ".gltf", ".lcc", ".usdz",   ".obj"};

std::string lower_extension(std::string_view name) {
  std::string extension = fs::path(name).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_one_of(std::string_view extension, const auto& all) {
  return std::find(all.begin(), all.end(), extension) != all.end();
}

/// Returns a safe file name: letters, digits, dots, dashes and underscores are kept, all else becomes '_'.
std::string tame(std::string_view name) {
  constexpr std::size_t kLongest = 80;
  std::string result;
  for (const char c : fs::path(name).filename().string()) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '_';
    result.push_back(plain ? c : '_');
  }
  if (result.size() > kLongest) result.erase(0, result.size() - kLongest);  // keeps the extension
  return result;
}

/// Returns `name` as it is if it is printable UTF-8; otherwise with the bytes that are no printable ASCII as
/// %XX, so that a message can carry it, and different names stay different.
std::string portable(const std::string& name) {
  if (printable(name) == name) return name;
  std::string result;
  for (const char c : name) {
    if (c >= ' ' && c <= '~')
      result.push_back(c);
    else
      result += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return result;
}

/// Returns why the .ply `file` is not a scene that can be read, by its header; empty if it is.
std::string refusal_of_header(const fs::path& file) {
  try {
    check_beginning(file.string());
    return {};
  } catch (const Error& error) {
    const std::string_view said = error.what();
    const std::string path = file.string() + ": ";  // of no concern to a page
    return std::string(said.starts_with(path) ? said.substr(path.size()) : said);
  }
}

bool is_inside(const fs::path& folder, const fs::path& file) {
  const auto [end, ignored] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  return end == folder.end();
}

}  // namespace

std::string refusal_of_format(std::string_view name) {
  const std::string extension = lower_extension(name);
  if (is_one_of(extension, kReadable)) return {};
  if (is_one_of(extension, kForeign))
    return fmt::format("{} cannot be read; convert it first: npx @playcanvas/splat-transform {} scene.ply",
                       extension, tame(name));
  return fmt::format("{} is not a scene; give a 3DGS .ply or .splat file", tame(name));
}

SceneLibrary::SceneLibrary(const std::vector<std::string>& folders, std::string first,
                           std::string_view option)
    : first_(std::move(first)) {
  for (const std::string& folder : folders) {
    std::error_code error;
    const fs::path whole = fs::canonical(folder, error);
    if (error) throw Error("{} {}: {}", option, folder, error.message());
    if (!fs::is_directory(whole, error)) throw Error("{} {}: is not a folder", option, folder);
    folders_.push_back(whole);
  }
}

std::vector<SceneLibrary::Found> SceneLibrary::find() const {
  std::vector<Found> found;
  found.push_back({{kBuiltIn, "The built-in still life"}, {}});
  const auto size = [](const fs::path& path) {
    std::error_code error;
    const std::uint64_t bytes = fs::file_size(path, error);
    return error ? 0 : bytes;
  };
  if (!first_.empty())
    found.push_back({{kFirst, portable(fs::path(first_).filename().string()), size(first_)}, first_});
  {
    const std::scoped_lock lock(mutex_);
    for (const std::string& path : handed_) {
      const std::string name = fs::path(path).filename().string();
      found.push_back({{"handed-over/" + name, name, size(path)}, path});
    }
  }
  for (std::size_t k = 0; k < folders_.size(); ++k) {
    const std::size_t begin = found.size();
    std::error_code error;
    fs::recursive_directory_iterator at(folders_[k], fs::directory_options::skip_permission_denied, error);
    for (const fs::recursive_directory_iterator end; !error && at != end && found.size() < kMost;
         at.increment(error)) {
      if (at.depth() >= kDeepest) at.disable_recursion_pending();
      std::error_code skipped;
      const std::string extension = lower_extension(at->path().filename().string());
      const bool readable = is_one_of(extension, kReadable);
      if (!readable && !is_one_of(extension, kForeign)) continue;
      const fs::path whole = fs::canonical(at->path(), skipped);  // a link may point to another folder
      if (skipped || !is_inside(folders_[k], whole) || !fs::is_regular_file(whole, skipped)) continue;
      const std::string name = portable(at->path().lexically_relative(folders_[k]).string());
      found.push_back({{fmt::format("{}/{}", k, name), name, size(whole),
                        !readable             ? refusal_of_format(name)
                        : extension == ".ply" ? refusal_of_header(whole)
                                              : ""},
                       whole.string()});
    }
    std::sort(found.begin() + static_cast<std::ptrdiff_t>(begin), found.end(),
              [](const Found& a, const Found& b) { return a.entry.name < b.entry.name; });
  }
  return found;
}

std::vector<SceneLibrary::Entry> SceneLibrary::list() const {
  std::vector<Entry> entries;
  for (Found& found : find()) entries.push_back(std::move(found.entry));
  return entries;
}

std::string SceneLibrary::path_of(std::string_view id) const {
  for (const Found& found : find()) {
    if (found.entry.id != id) continue;
    if (!found.entry.refusal.empty()) throw Error("{}", found.entry.refusal);
    return found.path;
  }
  throw Error("there is no scene '{}'; /palpate/list_scenes lists them",
              printable(std::string(id.substr(0, 80))));
}

std::string SceneLibrary::place_for(std::string_view name, std::uint64_t bytes) {
  if (const std::string refusal = refusal_of_format(name); !refusal.empty()) throw Error("{}", refusal);
  if (bytes == 0) throw Error("{} is empty", tame(name));
  const std::scoped_lock lock(mutex_);
  if (!own_) own_.emplace("palpate-scenes");
  const std::uint64_t free = fs::space(own_->path()).available;
  // The index file takes about as much again.
  if (free < kRoom || (free - kRoom) / 2 < bytes)
    throw Error("not enough disk space for {} ({} MB) in {}; open it from a folder of --scenes", tame(name),
                bytes >> 20U, own_->path().parent_path().string());
  // A folder per upload: the name is kept, and equal names do not collide.
  const fs::path folder = own_->path() / std::to_string(++count_);
  fs::create_directory(folder);
  return (folder / tame(name)).string();
}

void SceneLibrary::have(const std::string& path, std::span<const std::string> used) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(handed_, [&](const std::string& other) {
    if (std::find(used.begin(), used.end(), other) != used.end()) return false;
    std::error_code ignored;
    fs::remove_all(fs::path(other).parent_path(), ignored);
    return true;
  });
  handed_.push_back(path);
}

void SceneLibrary::drop(const std::string& path) {
  std::error_code ignored;
  fs::remove_all(fs::path(path).parent_path(), ignored);
}

}  // namespace palpate
