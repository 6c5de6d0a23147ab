/// \file
/// Library of the scenes that gateway clients may open.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/live/own_folder.h>

namespace palpate {

/// The scenes in the configured folders, the initial scene, uploaded scenes and the built-in one. Nothing
/// else can be opened, so that no web page can read other files. Any thread.
class SceneLibrary {
 public:
  /// \param folders searched two levels deep \param first SceneConfig::path of the initial scene \param
  /// option name of the option that set the folders, for messages \throws Error for a path that is not a
  /// folder.
  SceneLibrary(const std::vector<std::string>& folders, std::string first,
               std::string_view option = "--scenes");

  struct Entry {
    std::string id;            ///< for path_of(); printable UTF-8, as is `name`
    std::string name;          ///< for display; a file name's other bytes as %XX
    std::uint64_t bytes = 0;   ///< 0: not a file
    std::string refusal = {};  ///< why it cannot be read, by name and header, and what to do; empty: readable
  };
  /// Lists the scenes on the disk now: at most kMost, sorted by folder and name.
  std::vector<Entry> list() const;
  /// Returns SceneConfig::path of an entry of the current list(). \throws Error if there is no entry with
  /// that id, or it cannot be read.
  std::string path_of(std::string_view id) const;

  /// Returns a new path for an uploaded file `name` of `bytes` bytes, in a private folder that no other user
  /// can read. \throws Error if its format cannot be read, or the disk has no room for it.
  std::string place_for(std::string_view name, std::uint64_t bytes);
  /// Adds a completely uploaded file to the list, and deletes earlier uploads except those in use. \param
  /// used paths
  void have(const std::string& path, std::span<const std::string> used);
  /// Deletes an incomplete upload.
  void drop(const std::string& path);

  static constexpr std::size_t kMost = 500;
  static constexpr std::uint64_t kRoom = std::uint64_t{256} << 20;  ///< bytes that must stay free on the disk

 private:
  struct Found {
    Entry entry;
    std::string path;
  };
  std::vector<Found> find() const;

  std::vector<std::filesystem::path> folders_;  ///< canonical paths
  std::string first_;
  mutable std::mutex mutex_;         ///< guards the members below
  std::optional<OwnFolder> own_;     ///< has the uploaded files
  std::size_t count_ = 0;            ///< number of upload paths assigned so far
  std::vector<std::string> handed_;  ///< uploaded files, the newest last
};

/// Returns why a scene file of that name cannot be read, and how to convert it; empty if its format is
/// supported.
std::string refusal_of_format(std::string_view name);

}  // namespace palpate
