// Asks a captured scene what a tool touches and how it pushes back. Usage: contacts SCENE.ply X Y Z
#include <cstdlib>
#include <iostream>

#include <palpate/base/error.h>
#include <palpate/collision/open_index.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/haptics/settled_force.h>
#include <palpate/haptics/tool_query.h>

int main(int argc, char** argv) {
  if (argc != 5) {
    std::cerr << "usage: contacts SCENE.ply X Y Z\n";
    return 2;
  }
  try {
    const palpate::Similarity world_from_scene;  // the scene is in metres already
    const palpate::OpenedIndex opened =
        palpate::open_index(argv[1], palpate::SceneFilter{}, world_from_scene);

    palpate::Pose pose;
    pose.position = {std::atof(argv[2]), std::atof(argv[3]), std::atof(argv[4])};
    palpate::ContactSet contacts;
    const palpate::Tool tool;  // an ellipsoid of 20 x 20 x 40 mm
    palpate::query(opened.index, tool, pose, contacts);
    palpate::ProxyForce force(opened.index, tool);
    const palpate::Wrench wrench = palpate::settled_force(force, pose, contacts).wrench;
    std::cout << opened.report.kept << " Gaussians, " << contacts.contacts.size() << " in contact, force "
              << wrench.force.transpose() << " N\n";
  } catch (const palpate::Error& error) {
    std::cerr << "contacts: " << error.what() << "\n";
    return 1;
  }
}
