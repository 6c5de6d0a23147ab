/// \file
/// Force models by name.
#pragma once

#include <memory>
#include <string>

#include <palpate/collision/scene_index.h>
#include <palpate/haptics/field_force.h>
#include <palpate/haptics/proxy_force.h>

namespace palpate::test {

/// FieldForce where it is "field", else ProxyForce. `index` must outlive it.
inline std::unique_ptr<ForceModel> model_called(const std::string& name, const SceneIndex& index,
                                                const Tool& tool) {
  if (name == "field") return std::make_unique<FieldForce>(tool);
  return std::make_unique<ProxyForce>(index, tool);
}

}  // namespace palpate::test
