#include <palpate/gateway/contact_markers.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/rosbridge/ros_message.h>
#include <support/random_scenes.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::Random;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::uint32_t kGaussians = 400;

class ContactMarkersTest : public testing::Test {
 protected:
  static GaussianScene scene() {
    Random random(11);
    std::vector<test::Splat> splats;
    for (std::uint32_t k = 0; k < kGaussians; ++k) {
      const Vector3d position = random.in_box(1.0);
      const Vector3d sigma = random.semi_axes(1e-3, 0.1);
      splats.push_back(test::splat(position, sigma, random.rotation()));
    }
    return test::scene_of(splats);
  }

  Contact contact(std::uint32_t id, double depth = 0.001, double k_min = 0.5) const {
    Contact c;
    c.id = id;
    c.depth = depth;
    c.k_min = k_min;
    c.center = lookup.at(id).center;
    c.point = c.center + Vector3d(0, 0, 0.01);
    c.normal = Vector3d::UnitZ();
    return c;
  }

  Json message(std::vector<Contact> contacts) {
    return marker_array(head, markers.next(contacts, lookup)).at("markers");
  }

  /// Ids of the markers with this action, which are the same in both namespaces.
  static std::vector<int> ids(const Json& message, int action) {
    std::map<std::string, std::vector<int>> found;
    for (const Json& marker : message) {
      if (marker.at("action") == action) found[marker.at("ns")].push_back(marker.at("id"));
    }
    for (auto& [ns, of] : found) std::sort(of.begin(), of.end());
    EXPECT_EQ(found["contacts"], found["normals"]);
    EXPECT_EQ(found.size(), 2U);
    return found["contacts"];
  }
  static std::vector<int> added(const Json& message) { return ids(message, 0); }
  static std::vector<int> deleted(const Json& message) { return ids(message, 2); }

  SceneIndex index{scene(), {}, {}};
  EllipsoidLookup lookup{index};
  ContactMarkers markers;
  Json head = header({1, 2}, "world", 3);
};

TEST_F(ContactMarkersTest, EveryContactIsASphereWhereItsEllipsoidIsAndAnArrowAlongItsNormal) {
  Contact c = contact(7, 0.002);
  c.center += Vector3d(1e-9, 0, 0);  // in more digits than the lookup has
  const Json both = message({c});
  ASSERT_EQ(both.size(), 2U);
  Ellipsoid ellipsoid = lookup.at(7);
  ellipsoid.center = c.center;
  EXPECT_EQ(both[0], to_json(head, ellipsoid_marker("contacts", 7, ellipsoid,
                                                    {both[0]["color"]["r"], both[0]["color"]["g"],
                                                     both[0]["color"]["b"], both[0]["color"]["a"]})));
  const Json& arrow = both[1];
  EXPECT_EQ(arrow["ns"], "normals");
  EXPECT_EQ(arrow["id"], 7);
  EXPECT_EQ(arrow["points"][0], to_json(c.point));
  EXPECT_EQ(arrow["points"][1], to_json(Vector3d(c.point + 0.002 * Vector3d::UnitZ())));
  for (const Json& marker : both) EXPECT_EQ(marker["header"], head);
}

TEST_F(ContactMarkersTest, DeeperIsBrighter) {
  double last = -1.0;
  for (const double k : {-1.0, 0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0, 2.0}) {
    const Json color = message({contact(1, 0.001, k)})[0]["color"];
    double lightness = 0.0;
    for (const auto& [name, weight] :
         std::map<std::string, double>{{"r", 0.2126}, {"g", 0.7152}, {"b", 0.0722}}) {
      const double value = color[name];
      EXPECT_GE(value, 0.0);
      EXPECT_LE(value, 1.0);
      lightness += weight * value;
    }
    if (k <= 0.0 || k > 1.0) {
      EXPECT_GE(lightness, last);
    } else {
      EXPECT_GT(lightness, last) << k;
    }
    last = lightness;
  }
}

TEST_F(ContactMarkersTest, WhatIsGoneIsDeletedInAsManyMessagesAsAClientMayMiss) {
  EXPECT_THAT(added(message({contact(1), contact(2)})), ElementsAre(1, 2));
  for (std::uint64_t k = 1; k <= ContactMarkers::kReach; ++k) {
    const Json next = message({contact(2)});
    EXPECT_THAT(added(next), ElementsAre(2)) << k;
    EXPECT_THAT(deleted(next), ElementsAre(1)) << k;
  }
  const Json after = message({contact(2)});
  ASSERT_EQ(after.size(), 2U) << "nothing is deleted any longer";
  EXPECT_THAT(added(after), ElementsAre(2));
}

TEST_F(ContactMarkersTest, WhatComesBackIsDeletedNoLonger) {
  message({contact(1)});
  for (int k = 0; k < 5; ++k) EXPECT_THAT(deleted(message({})), ElementsAre(1));
  const Json back = message({contact(1)});
  EXPECT_EQ(back.size(), 2U);
  EXPECT_THAT(added(back), ElementsAre(1));
  // And is again deleted as often as at first.
  for (std::uint64_t k = 0; k < ContactMarkers::kReach; ++k)
    EXPECT_THAT(deleted(message({})), ElementsAre(1)) << k;
  EXPECT_THAT(message({}), IsEmpty());
}

TEST_F(ContactMarkersTest, ShowsTheDeepest) {
  std::vector<Contact> contacts;
  for (std::uint32_t id = 0; id < kGaussians; ++id)
    contacts.push_back(contact(id, 1e-4 * ((id * 37U) % kGaussians + 1)));  // all different
  const std::vector<int> shown = added(message(contacts));
  ASSERT_EQ(shown.size(), ContactMarkers::kMost);
  std::vector<int> deepest;
  for (std::uint32_t id = 0; id < kGaussians; ++id) {
    if ((id * 37U) % kGaussians >= kGaussians - ContactMarkers::kMost)
      deepest.push_back(static_cast<int>(id));
  }
  EXPECT_EQ(shown, deepest);
}

TEST_F(ContactMarkersTest, WhatIsNoLongerAmongTheDeepestIsDeleted) {
  std::vector<Contact> contacts;
  for (std::uint32_t id = 0; id < ContactMarkers::kMost; ++id) contacts.push_back(contact(id, 0.01));
  contacts[5].depth = 0.001;
  EXPECT_EQ(added(message(contacts)).size(), ContactMarkers::kMost);
  contacts.push_back(contact(300, 0.02));
  const Json next = message(contacts);
  EXPECT_EQ(added(next).size(), ContactMarkers::kMost);
  EXPECT_THAT(deleted(next), ElementsAre(5));
}

TEST_F(ContactMarkersTest, IsOneOfEachIdTheDeepest) {
  std::vector<Contact> contacts{contact(3, 0.001), contact(4, 0.002), contact(3, 0.005), contact(3, 0.003)};
  for (std::size_t k = 0; k < contacts.size(); ++k) contacts[k].part = static_cast<std::uint32_t>(k);
  const Json both = message(contacts);
  EXPECT_THAT(added(both), ElementsAre(3, 4));
  for (const Json& marker : both) {
    if (marker["ns"] != "normals" || marker["id"] != 3) continue;
    const double length = marker["points"][1]["z"].get<double>() - marker["points"][0]["z"].get<double>();
    EXPECT_NEAR(length, 0.005, 1e-12);
  }
}

// The deepest are so many different ones, though one that several parts touch is there several times.
TEST_F(ContactMarkersTest, CountsAnIdOnce) {
  std::vector<Contact> contacts;
  for (std::uint32_t id = 0; id < ContactMarkers::kMost; ++id) {
    for (int part = 0; part < 3; ++part) contacts.push_back(contact(id, 0.001 * (id + 1)));
  }
  const std::vector<int> shown = added(message(contacts));
  EXPECT_EQ(shown.size(), ContactMarkers::kMost);
  EXPECT_EQ(std::set<int>(shown.begin(), shown.end()).size(), ContactMarkers::kMost);
}

TEST_F(ContactMarkersTest, WhoFollowsFromAnyMessageOnSeesWhatThereIs) {
  // A client that sees every n-th message, n up to kReach, and applies it, has what the newest one has.
  Random random(12);
  std::set<int> shown;
  std::vector<Contact> contacts;
  int unseen = 0;
  for (int k = 0; k < 600; ++k) {
    contacts.clear();
    for (std::uint32_t id = 0; id < 20; ++id) {
      if (random.integer(0, 3) == 0) contacts.push_back(contact(id));
    }
    const Json next = message(contacts);
    ++unseen;
    if (unseen < static_cast<int>(ContactMarkers::kReach) && random.integer(0, 40) != 0) continue;
    unseen = 0;
    for (const Json& marker : next) {
      if (marker["ns"] != "contacts") continue;
      if (marker["action"] == 0) shown.insert(marker["id"].get<int>());
      if (marker["action"] == 2) shown.erase(marker["id"].get<int>());
    }
    std::set<int> there;
    for (const Contact& c : contacts) there.insert(static_cast<int>(c.id));
    ASSERT_EQ(shown, there) << k;
  }
}

// A tool of two parts; 2 N along z are an arrow of 40 mm.
TEST(HandMarkers, AreThePartsAndTheForceOnTheHand) {
  const Tool tool({{"palm", {0.01, 0.01, 0.01}}, {"finger", {0.02, 0.01, 0.01}, Pose{{0.1, 0, 0}}}});
  TickRecord tick;
  tick.tool.position = {1, 2, 3};
  tick.sent_world.force = {0, 0, 2};
  const std::vector<Marker> markers = hand_markers("left", 0, tool, tick);
  ASSERT_EQ(markers.size(), 3U);
  EXPECT_EQ(markers[0].ns, "left");
  EXPECT_EQ(markers[1].pose.position, Vector3d(1.1, 2, 3));
  const Marker& force = markers[2];
  EXPECT_EQ(force.ns, "left/force");
  ASSERT_EQ(force.points.size(), 2U);
  EXPECT_EQ(force.points[0], tick.tool.position);
  EXPECT_NEAR((force.points[1] - Vector3d(1, 2, 3.04)).norm(), 0.0, 1e-12);
  EXPECT_GT(force.color.a, markers[0].color.a) << "parts are seen through";
}

TEST_F(ContactMarkersTest, TheResetDeletesAll) {
  EXPECT_EQ(ContactMarkers::reset().action, Marker::Action::kDeleteAll);
}

}  // namespace
}  // namespace palpate
