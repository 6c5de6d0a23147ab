/// \file
/// Results as Markdown and JSON.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include <palpate/study/machine.h>

#include "comparison.h"
#include "scene_file.h"

namespace palpate::bench {

/// One line on the setting, and the table of the pipelines.
std::string to_markdown(const Comparison& comparison);

/// Cost of indexing and opening the file, as a list.
std::string to_markdown(const SceneFileResult& file);

nlohmann::ordered_json to_json(const Comparison& comparison);
nlohmann::ordered_json to_json(const SceneFileResult& file);

/// Prints `markdown`, and writes the files whose path is not empty. \throws Error if one cannot be written.
void publish(const std::string& markdown, const std::string& markdown_path,
             const nlohmann::ordered_json& json, const std::string& json_path);

}  // namespace palpate::bench
