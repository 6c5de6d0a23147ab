/// \file
/// Results as Markdown for people and as JSON for programs.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include <palpate/study/machine.h>

#include "comparison.h"
#include "scene_file.h"

namespace palpate::bench {

/// What was compared, in one line, and the table of the pipelines.
std::string to_markdown(const Comparison& comparison);

/// What it takes to index and to open the file, as a list.
std::string to_markdown(const SceneFileResult& file);

nlohmann::ordered_json to_json(const Comparison& comparison);
nlohmann::ordered_json to_json(const SceneFileResult& file);

/// Prints `markdown` and writes both files, where a name is given. \throws Error if one cannot be written.
void publish(const std::string& markdown, const std::string& markdown_path,
             const nlohmann::ordered_json& json, const std::string& json_path);

}  // namespace palpate::bench
