// What one query may ask for at most. All of it can be read from /v1/status.
#pragma once

#include <cstddef>
#include <cstdint>

namespace geodesic::proto {

// By some methods each source has a wave of its own, by all each row of a table has one. Each point
// is looked up and answered.
inline constexpr std::size_t kMaxSources = 1000;
inline constexpr std::size_t kMaxPoints = 100'000;
// Of the curves of a query: each leg is a shortest path, which may take a field.
inline constexpr std::size_t kMaxCurvePoints = 1000;
// Of its curves, too: straight pieces within faces, some 400 bytes each.
inline constexpr std::size_t kMaxCurvePieces = 1'000'000;
// Each leg of a path has a field of its own.
inline constexpr std::size_t kMaxVia = 100;
// The same of a loop.
inline constexpr std::size_t kMaxLoopPoints = 100;
inline constexpr std::size_t kMaxTableEntries = 1'000'000;
// Of a table whose rows are sent as they are done, or of which only what is near is kept.
inline constexpr std::uint64_t kMaxStreamedEntries = 1'000'000'000;
// Of a table, in columns that are curves, boundaries or faces: 80 MB.
inline constexpr std::uint64_t kMaxLineEntries = 10'000'000;
// Of a sparse table, those that it has: 240 MB.
inline constexpr std::uint64_t kMaxSparseEntries = 20'000'000;
// Of a table that is estimated. Some 30 ms for what lies between them.
inline constexpr std::uint64_t kFewestLandmarks = 8;
inline constexpr std::uint64_t kMaxLandmarks = 300;
// Vertices and points on edges of `steiner`; some 800 MB.
inline constexpr std::uint64_t kMaxSteinerNodes = 20'000'000;
inline constexpr std::size_t kMaxLevels = 10'000;
// Some 60 MB of JSON.
inline constexpr std::uint64_t kMaxIsolineSegments = 1'000'000;
inline constexpr std::uint64_t kMaxSamples = 10'000;
// Of the discs of one measure.
inline constexpr std::size_t kMaxRadii = 1000;
// Of Lloyd's relaxation, each with a field of each site.
inline constexpr std::uint64_t kMaxRelax = 100;
// Of an extent, one after the other.
inline constexpr std::uint64_t kMaxFields = 1'000;
// Of a region; each goes through all faces once.
inline constexpr std::size_t kMaxRegionShapes = 1'000;
// Of the labels of a query: each is read out of the file, and has a number for each face.
inline constexpr std::size_t kMaxLabelAttributes = 10;
// Of a weight and of a rate, and of the slopes of a table.
inline constexpr double kLeastWeight = 1e-9;
inline constexpr double kMostWeight = 1e9;
inline constexpr std::size_t kMaxSlopes = 1'000;
// Of the regions of a query, single faces among them.
inline constexpr std::uint64_t kMaxFaceRanges = 100'000;
// Of a query, those round insides not among them.
inline constexpr std::size_t kMaxWalls = 1'000;
// Of all walls and insides of a query; where two in a row are in no face together, the shortest
// path between them is searched for.
inline constexpr std::size_t kMaxLinePoints = 10'000;
// That these lines make where they cross edges, turn inside faces and, of walls, in the middle of
// each piece; some 1 kB each, on the way.
inline constexpr std::uint64_t kMaxLineVertices = 200'000;

}  // namespace geodesic::proto
