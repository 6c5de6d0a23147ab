#include <palpate/live/run_recordings.h>

#include <filesystem>

#include <palpate/base/error.h>
#include <palpate/live/provenance.h>

namespace palpate {
namespace {

/// RUN-NAME.csv for RUN.csv.
std::string file_of(const std::string& hand, const std::string& path) {
  std::filesystem::path file(path);
  if (!hand.empty()) file.replace_filename(file.stem().string() + "-" + hand + file.extension().string());
  return file.string();
}

}  // namespace

RunRecordings::RunRecordings(const std::string& path, const LiveHands& hands, std::string_view command) {
  if (path.empty()) return;
  try {
    for (const LiveHands::Hand& hand : hands.all()) {
      RecorderOptions options = recorder_options(hand.system->device());
      options.made = to_toml(hand.system->provenance(command));
      all_.push_back(std::make_unique<HandRecording>(file_of(hand.name, path), options));
    }
  } catch (const Error&) {  // those of the hands before it have no rows
    for (const auto& recording : all_) std::filesystem::remove(recording->path);
    throw;
  }
}

TickObserver* RunRecordings::observer(std::size_t hand) const {
  return all_.empty() ? nullptr : &all_[hand]->observer;
}

std::optional<std::string> RunRecordings::failure() const {
  for (const auto& recording : all_)
    if (auto failure = recording->recorder.failure()) return failure;
  return std::nullopt;
}

void RunRecordings::close() {
  for (const auto& recording : all_) recording->recorder.close();
}

}  // namespace palpate
