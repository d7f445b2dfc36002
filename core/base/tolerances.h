// What rounding may do: every bound below which two results count as the same.
//
// A double has 16 digits, and one operation loses 1.1e-16 of its result. Each bound lies above what
// the sums, products and roots before it lose, and below what a caller would notice. A bound is
// relative unless a unit is stated: "of the edge" means a part of the edge's length. Where two
// bounds have the same subject, each says why it is not the other.
//
// Numbers that trade time for accuracy (how wide a bucket is, how far a trace goes) are not here.
// They stand beside the code that they tune.
#pragma once

#include <limits>

namespace geodesic::tolerance {

// ---- Lengths and distances ----------------------------------------------------------------------

// Of two distances that windows give to one vertex or place: a sum and a root each.
inline constexpr double kSameDistance = 1e-13;
// Of two ways to a place that are computed by the same formula over neighbouring faces, and of the
// difference of two distances against the edge between them.
inline constexpr double kSameWay = 1e-12;
// Of two lengths that are computed over different faces, or summed over many: a path and its
// distance, a distance and the straight line in space.
inline constexpr double kSamePath = 1e-9;
// Of what a path or a distance must gain for a change to count. Rounding gains less, so a loop
// that goes on while it gains comes to an end.
inline constexpr double kLeastGain = 1e-14;
// Of the length that a straightest geodesic may end short of: a line that ends on an edge does not
// go on into the next face.
inline constexpr double kMissingLength = 1e-13;
// Of a distance and of the mesh's extent: what may be missing from distances by windows, which keep
// no account of their rounding. Against 113 bits, on small surfaces of sides from 1 to 1e9, they
// were never below by more than 6e-13.
inline constexpr double kWindows = 1e-11;
// Of a distance that a way along an edge undercuts, where windows were lost and must be replaced.
inline constexpr double kLostWindow = 1e-11;
// Of a way: the least shortening by unfolding (unfold_rounding.h) that is made up for.
inline constexpr double kLeastLack = 1e-10;
// Of a distance. A shorter edge is a point: in the sum of both, its length is lost. What goes
// through it goes by its ends, and is longer by no more than twice its length.
inline constexpr double kPoint = 1e-12;
// Of a distance that is kept in single precision: one rounding.
inline constexpr double kSinglePrecision = 1.2e-7;
// Of a distance, as an offset of a crossing: 16 roundings in single precision. A vertex on the way
// that was missed by that little sent one path in a hundred over a regular plane astray, by 1 % of
// its length.
inline constexpr double kSinglePrecisionCrossing = 16 * 6e-8;

// ---- Faces and sides ----------------------------------------------------------------------------

// Of the longest side, a face's height: below it Mesh::build counts the face as without area.
// Coordinates in double precision say nothing of a lesser height.
inline constexpr double kZeroArea = 1e-12;
// The same where windows cross the face. Its two sides are one line then, and a window leaves by
// both. Three digits are lost on the way into the plane.
inline constexpr double kWindowZeroArea = 1e-9;
// The same where angles are measured: a thinner face has none.
inline constexpr double kThin = 1e-10;
// Of longest side times shortest side, twice a face's area: below it the face is a line.
inline constexpr double kLine = 1e-14;
// Of half the sum of the squared sides, twice a face's area: below it, what is computed across the
// face may be anything.
inline constexpr double kWithoutArea = 1e-10;
// The same: below it, the way along the face's sides may be shorter than what is computed across
// it, by a rule that waits until two corners have their distance, or by rounding.
inline constexpr double kFlat = 1e-3;
// Of the longest side, a face's height: a flip that leaves less gains nothing that rounding would
// not take away again.
inline constexpr double kFlippedHeight = 1e-14;
// Of the longest side: what flips may lose in all, as intrinsic_faces.h reckons it.
inline constexpr double kFlips = 1e-11;
// Of a sum or product in numbers of two doubles, with room for the twenty in a row of one flip.
inline constexpr double kDoubleDouble = 0x1p-98;
// Of the two products that a squared length is the sum of: less is what rounding leaves when they
// are nearly opposite. Half of the digits.
inline constexpr double kHalfOfDigits = 1e-9;
// Of the longest side, squared: from the squares of sides a shorter line within a face has fewer
// than twelve digits.
inline constexpr double kNearInFace2 = 1e-4;
// Of the greater of these two products: below it, the length has lost more than three digits, and
// where it is to be right to kWindows, it comes from the positions.
inline constexpr double kFewDigits = 1e-3;
// Of the longest side: what a length computed from two such products may be off.
inline constexpr double kSide = 8 * std::numeric_limits<double>::epsilon();
// Of the longest side, squared: beside a shorter side, rounding says where the other one is.
inline constexpr double kLeastSide2 = 1e-12;
inline constexpr double kLeastSide = 1e-6;
// The greatest squared ratio of longest to shortest length that unfolding needs no account for. Up
// to it, rounding turns nothing that a trace goes over by more than 2e-10.
inline constexpr double kMostSpread2 = 1e6;
// Of the greatest distance unfolded so far: the error of the corner that one step unfolds.
inline constexpr double kUnfolding = 16 * std::numeric_limits<double>::epsilon();

// ---- Angles -------------------------------------------------------------------------------------

// Of two angles that add up to pi in an intrinsic Delaunay triangulation: without a margin, four
// vertices on one circle would be flipped to and fro.
inline constexpr double kDelaunay = 1e-12;
// Of 2 pi. A vertex whose angles exceed it by more is a saddle for `chen_han`, where a vertex too
// many costs a window and one too few a distance: on a flat grid, no vertex is one.
inline constexpr double kSaddle = 1e-12;
// The same in radians for `exact`, which may miss a saddle this slight: going straight past the
// vertex is longer by the angle's square only.
inline constexpr double kAngle = 1e-9;
// In radians, how far an angle may be beyond the end of a fan.
inline constexpr double kFanEnd = 1e-12;
// In radians, what a turn may be for a straight piece of a path to run through the vertex. Both
// sides of the vertex are looked at then.
inline constexpr double kThroughVertex = 1e-12;
// In radians. A path's vertex with sides this close to pi stays where it is: over arms as long as
// each other the path is longer than the shortest by one part in 1e15.
inline constexpr double kStraightAngle = 1e-7;
// In radians, summed over faces. Beyond an edge that may be turned by more, unfolding says nothing.
inline constexpr double kMostTurn = 1e-9;
// In radians, how much wider the windows of a pseudo-source are than the angle it is the source in:
// the direction in which its own distance came is known to about the square root of rounding.
inline constexpr double kDirection = 1e-5;
// Of a vector: the least that its projection may have.
inline constexpr double kNoProjection = 1e-12;

// ---- Places on an edge, of its length -----------------------------------------------------------

// A crossing nearer to an end than this is that end: the face across would see nothing of the
// surface on the vertex's other side.
inline constexpr double kAtEnd = 1e-9;
// The same where ways of the same length stand for choice, and rounding alone decides.
inline constexpr double kAtEndSurely = 1e-14;
// The most that single precision may make of it, however short the edge.
inline constexpr double kMostAtEnd = 1e-4;
// The same for a straightest geodesic, whose direction is given and need not be guessed …
inline constexpr double kAtVertex = 1e-12;
// … where it passes the vertex by less than this angle, in radians, too: a line may well go round
// a ring that is no wider than that part of the edges that begin there.
inline constexpr double kPassesVertex = 1e-9;
// Of the spacing: a point nearer to one of `steiner`'s points is that point.
inline constexpr double kAtSteinerPoint = 1e-6;
// Of the longest side, squared: a step that is shorter stays where it is.
inline constexpr double kStays2 = 1e-14;

// ---- Windows, of their edge's length ------------------------------------------------------------

// Intervals that overlap by less only touch.
inline constexpr double kTouch = 1e-13;
// The least width of a window; of the shorter of its edge and its rays in `exact`, of the edge and
// in radians as seen from the source in `chen_han`.
inline constexpr double kLeastWidth = 1e-12;
// Of a face's longest side: from a source that is nearer to a corner, the windows that go round the
// corner may be too narrow to be kept. So what comes to the corner bends there too.
inline constexpr double kBesideCorner = 1e-6;
// Gaps below this need not be looked into: what is in them is no farther than from their ends.
inline constexpr double kLeastGap = 1e-9;
// Windows of one source that are no farther apart may be one, if it makes no difference …
inline constexpr double kNearlyTouch = 1e-6;
// … and their unfolded sources are nearer to each other than this part of their distance.
inline constexpr double kNearSource = 1e-6;
// Of how far a window is from its unfolded source along the edge: where the source is no deeper
// than this part, all rays of the window run along the edge.
inline constexpr double kAlongEdge = 1e-6;
// Of the distance: unfolded sources that are nearer to each other are one, unfolded over different
// faces.
inline constexpr double kSameSource = 3e-14;
// Sources that are nearer to each other are one and the same, where all windows that crossed an
// edge are compared: rounding moves them by less, and a ray between them strays no farther than
// that.
inline constexpr double kSamePlace = 1e-10;
// Lines from two sources to one vertex that cross an edge nearer to each other may be the same
// line.
inline constexpr double kSameLine = 1e-9;
// A window whose end the line to a corner misses by no more sees the corner.
inline constexpr double kNearlyMet = 1e-9;
// A source below an edge by no more is on the edge's line …
inline constexpr double kOnLine = 1e-13;
// … or, of its distance, above a side's line: it was unfolded over a face, whose height lost half
// of the digits.
inline constexpr double kOnUnfoldedLine = 1e-8;
// How far below an edge a source on its line is put, far below what rounding can tell: no formula
// divides nothing by nothing.
inline constexpr double kDepthOnLine = 1e-20;
// A factor: a bent way is longer than a straight one of the same length by this, so that of the two
// the straight one is taken.
inline constexpr double kBent = 1 + 0x1p-50;

// ---- Points in space, in the frame in which the mesh fills [-1, 1] ------------------------------

// Of boxes in double precision, where the mesh and the point are no larger than some 10.
inline constexpr double kBox = 1e-12;
// Of Embree's boxes in single precision: more than what the rounding of corners, origins and
// directions adds up to.
inline constexpr double kEmbreeBox = 4e-6;
// Of a ray's length in single precision.
inline constexpr double kEmbreeRay = 1e-5;

}  // namespace geodesic::tolerance
