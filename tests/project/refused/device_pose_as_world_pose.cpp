// Is refused by the compiler with REFUSED, and compiles without it: see refused_test.sh.
#include <palpate/haptics/tool.h>
#include <palpate/servo/safety_governor.h>
#include <palpate/servo/workspace_map.h>

palpate::Ellipsoid solid(const palpate::ToolPart& part, const palpate::DeviceReading& reading,
                         const palpate::WorkspaceMap& map) {
#ifdef REFUSED
  (void)map;
  return part.at(reading.pose);
#else
  return part.at(map.to_world(reading.pose));
#endif
}
