// How much a pixel of the predicted view is known, in its alpha: see viewer/gap_filler.h. In 1/255, so that the mean of
// two that meet in a pixel is something between them:
//   0       nothing was seen here of what lies behind everything: the backdrop, or nothing at all (back faces: seen)
//   1, 2    a polygon that no picture has shown, a hole of one that has been shown in part
//   to 32   what lies behind, by how much of it was observed
//   to 255  a polygon, by how much of it was observed
const float kKnownNever = 1.0 / 255.0, kKnownHole = 2.0 / 255.0, kKnownBehind = 32.0 / 255.0;

// Where this share of the texels was observed; a texel beside a filled one has some of its colour.
float known_of(float observed, bool behind) {
  float known = clamp(2.0 * observed - 1.0, 0.0, 1.0);
  if (behind) return kKnownBehind * known;
  return known > 0.0 ? mix(kKnownBehind, 1.0, known) : kKnownHole;
}

bool is_polygon(float known) { return known > kKnownBehind + 0.5 / 255.0; }
bool is_behind(float known) { return !is_polygon(known) && (known > kKnownHole + 0.5 / 255.0 || known < 0.5 / 255.0); }
float share_of_polygon(float known) { return (known - kKnownBehind) / (1.0 - kKnownBehind); }
float share_behind(float known) { return min(known / kKnownBehind, 1.0); }
