#include "foreview/viewer/texture_proposal.h"

#include <gtest/gtest.h>

#include "support/temporary_directory.h"
#include "viewer/small_recording.h"

namespace foreview {
namespace {

TEST(TextureProposal, RoundNumbers) {
  EXPECT_DOUBLE_EQ(round_number(262.5), 300);
  EXPECT_DOUBLE_EQ(round_number(240), 200);
  EXPECT_DOUBLE_EQ(round_number(500), 500);
  EXPECT_DOUBLE_EQ(round_number(52), 50);
  EXPECT_DOUBLE_EQ(round_number(90), 100);
  EXPECT_DOUBLE_EQ(round_number(1999), 2000);
  EXPECT_DOUBLE_EQ(round_number(0.013), 0.015);
}

TEST(TextureProposal, IsWhatThePicturesResolve) {
  const test::TemporaryDirectory directory;
  test::SmallSite site;
  site.camera.width = 192;
  site.camera.height = 144;
  site.camera.focal_length = {180, 180};
  site.camera.principal_point = {96, 72};
  site.instants = 2;
  site.write(directory / "recording");
  const Recording recording = Recording::open(directory / "recording");
  // Nearly all rays meet the wall at 2 m, a minority the board at 1 m: 90 pixels a metre. The wall spans 3 m of them.
  const PolygonModel model = build_polygon_model(test::SmallSite::mesh(), recording.import_options());
  const TextureProposal proposal = propose_textures(recording, model);
  EXPECT_DOUBLE_EQ(proposal.texels_per_metre, 100);
  EXPECT_EQ(proposal.max_texels, 512);
}

TEST(TextureProposal, WithoutAnythingInViewIsTheUsual) {
  const test::TemporaryDirectory directory;
  test::SmallSite site;
  site.instants = 1;
  site.write(directory / "recording");
  const Recording recording = Recording::open(directory / "recording");
  RawMesh behind = test::SmallSite::mesh();
  for (glm::dvec3& vertex : behind.vertices) vertex.z -= 10;
  // The backdrop is no surface to judge by.
  ImportOptions options;
  options.backdrop = true;
  const TextureProposal proposal = propose_textures(recording, build_polygon_model(behind, options));
  EXPECT_DOUBLE_EQ(proposal.texels_per_metre, 500);
}

TEST(TextureProposal, OfAModelAloneGoesByItsSize) {
  // The ball around wall and board has a radius of some 2.3 m (2.6 pixels of 600 a centimetre); the wall spans 3 m.
  RawMesh mesh = test::SmallSite::mesh();
  const TextureProposal proposal = propose_textures(build_polygon_model(mesh, {.backdrop = true}));
  EXPECT_DOUBLE_EQ(proposal.texels_per_metre, 300);
  EXPECT_EQ(proposal.max_texels, 1024);
  for (glm::dvec3& vertex : mesh.vertices) vertex *= 0.1;
  EXPECT_DOUBLE_EQ(propose_textures(build_polygon_model(mesh, {.backdrop = false})).texels_per_metre, 2000);
}

}  // namespace
}  // namespace foreview
