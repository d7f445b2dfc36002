// What each query answers, as values, and their JSON.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/vec3.h"
#include "core/paths/discs.h"
#include "core/paths/isolines.h"
#include "core/paths/strips.h"
#include "core/voronoi/bisectors.h"
#include "core/voronoi/voronoi.h"
#include "proto/wire/methods.h"
#include "proto/wire/requests.h"

namespace geodesic::proto {

// What a source that is no point has become.
struct ResolvedLines {
  std::string_view kind;     // "curve", "boundary" or "faces"
  double length = 0;         // of its lines, mesh units
  std::uint64_t pieces = 0;  // of them, each straight within a face or along an edge
  std::uint64_t faces = 0;   // at distance 0
};

// A point found on a mesh, in the client's numbers. Every reply echoes the points of its request in
// this form.
struct ResolvedPoint {
  std::optional<std::uint64_t> vertex;  // a source vertex, when it is one
  std::optional<std::uint64_t> face;    // a source face; none at a vertex without faces
  std::array<double, 3> bary{};
  Vec3 xyz;
  double snap_distance = 0;            // from what was asked to what was found, mesh units
  std::optional<double> ray_distance;  // of a ray's first hit: from its origin, mesh units
  std::optional<ResolvedLines> lines;  // where this is just the first point of a source
};

// What the asker may not have meant, a sentence of plain ASCII each; in JSON only where there is
// any.
using Warnings = std::vector<std::string>;

struct DistanceReply {
  std::string mesh;
  Method method = Method::wavefront;
  std::vector<ResolvedPoint> from;
  std::optional<std::vector<ResolvedPoint>> at;
  std::vector<double> distances;  // one per source vertex, or one per `at`; infinite: unreached
  std::uint64_t reached = 0;      // how many of them are finite
  std::optional<double> max;      // the greatest of them, without its sign
  std::optional<std::uint64_t> farthest;  // and where: a source vertex, or a place in `at`
  bool short_digits = false;              // see append_distance
  Bound bound = Bound::none;              // upper: rounded up where digits are cut
  std::optional<std::string_view> unit;   // of costs, where distances are those
  bool is_signed = false;                 // below 0 inside
  // Only if asked for: which of `from` each distance is from, kNone where infinite.
  std::optional<std::vector<std::uint32_t>> labels;
  Warnings warnings;
};

struct PathReplyPoint {
  Vec3 xyz;
  std::optional<std::uint64_t> face;  // source face of the segment that leaves this point
  std::array<double, 3> bary{};
};

// What a path costs, and each of its segments, one fewer than it has points.
struct PathCosts {
  std::string_view unit;
  double whole = 0;
  std::vector<double> lengths;  // mesh units
  std::vector<double> costs;
};

struct PathReply {
  std::string mesh;
  Method method = Method::wavefront;
  Refine refine = Refine::none;
  ResolvedPoint from;
  std::vector<ResolvedPoint> via;
  ResolvedPoint to;
  bool reachable = false;
  double length = 0;          // mesh units; meaningless when not reachable
  Bound bound = Bound::none;  // upper: the length is rounded up where digits are cut
  std::vector<PathReplyPoint> points;
  std::optional<PathCosts> costs;  // where ways are cheap instead of short
  Warnings warnings;
};

// What is reached of a table, row after row, and in each by ascending columns: compressed sparse
// rows. The arrays are bytes as they are sent, little-endian.
struct SparseEntries {
  std::vector<std::uint32_t> begins{0};  // of each row, and their end
  std::string columns;                   // uint32
  std::string distances;                 // float64
  [[nodiscard]] std::uint64_t count() const { return columns.size() / sizeof(std::uint32_t); }
};

// Of a table most of whose entries are estimated: how many of its columns have a whole field, and
// by how much estimates are off that were compared with some other columns' fields, relative to
// these.
struct Estimated {
  std::uint64_t landmarks = 0;
  double mean = 0;
  double percentile_99 = 0;
  double max = 0;
  std::uint64_t entries = 0;  // that were compared
};

struct TableReply {
  std::string mesh;
  Method method = Method::wavefront;
  std::vector<ResolvedPoint> rows;
  std::vector<ResolvedPoint> columns;
  std::vector<double> distances;         // row after row; infinite: unreached
  std::optional<SparseEntries> sparse;   // instead of them
  bool short_digits = false;             // see append_distance
  Bound bound = Bound::none;             // upper: rounded up where digits are cut
  std::optional<std::string_view> unit;  // of costs, where distances are those
  std::optional<Estimated> estimated;
  Warnings warnings;
};

struct IsolinesReply {
  std::string mesh;
  Method method = Method::wavefront;
  std::vector<ResolvedPoint> from;
  std::optional<double> max;   // the greatest distance within the one asked for
  std::vector<double> levels;  // ascending, whether or not they have a line
  std::vector<Isoline> isolines;
  std::optional<std::string_view> unit;  // of costs, where levels are those
  Warnings warnings;
};

struct SampleReply {
  std::uint64_t vertex = 0;  // source vertex
  Vec3 xyz;
  double radius = 0;  // infinite: nothing before it on its component
};

struct SamplesReply {
  std::string mesh;
  Method method = Method::wavefront;
  std::vector<ResolvedPoint> from;
  std::vector<SampleReply> samples;
  double covering_radius = 0;
  Bound bound = Bound::none;  // upper: radii are rounded up where digits are cut
  Warnings warnings;
};

struct MeasureReply {
  std::string mesh;
  Method method = Method::wavefront;
  std::vector<ResolvedPoint> from;
  // Of the surface that is reached, or as far as was asked for:
  double area = 0;
  double mean = 0;                        // of the distance over it
  std::optional<double> max;              // the greatest distance of a vertex
  std::optional<std::uint64_t> farthest;  // the source vertex that has it
  std::vector<Disc> discs;                // by radius
  Bound bound = Bound::none;              // upper: `max` is rounded up where digits are cut
  std::vector<Strip> strips;              // of a drawing alone
  double reach = 0;                       // where the last strip ends
  Warnings warnings;
};

struct ExtentReply {
  struct Vertex {
    std::uint64_t vertex = 0;  // source vertex
    Vec3 xyz;
  };
  std::string mesh;
  Method method = Method::wavefront;
  ExtentRequest::Of of = ExtentRequest::Of::diameter;
  double value = 0;       // mesh units
  double lower = 0;       // the true one is not below
  double upper = 0;       // nor above; infinite: nothing is known
  double confidence = 1;  // with which that is so
  bool is_exact = false;
  std::vector<Vertex> vertices;     // two of a diameter, one of a centre or a median
  std::uint64_t fields = 0;         // that were computed
  std::uint64_t part_vertices = 0;  // of the part that was measured, copies counted once
  // Of `means` alone, by source vertex: its mean distance, infinite outside of the part, and what
  // is to be added to either side.
  std::vector<double> means;
  std::vector<double> margins;
};

// Cells are called by the numbers of their sites in `from`.
struct VoronoiReply {
  struct Cell {
    ResolvedPoint site;  // where relaxing left it
    double area = 0;     // lengths and areas in mesh units
    double perimeter = 0;
    double boundary = 0;
    std::uint64_t vertices = 0;             // source vertices
    std::optional<ResolvedPoint> centroid;  // none of a cell without area
  };
  struct Triangle {
    std::array<std::uint32_t, 3> cells{};
    ResolvedPoint point;  // where they meet
    double distance = 0;  // of that from the three sites
  };
  std::string mesh;
  Method method = Method::wavefront;
  std::vector<ResolvedPoint> from;
  std::uint64_t relax = 0;
  std::vector<Cell> cells;
  std::vector<NeighbourCells> neighbours;
  std::vector<Bisector> bisectors;
  std::vector<Triangle> triangles;
  // Of a drawing alone: which part of it, and the triangles of each cell.
  struct DrawnCell {
    std::vector<Vec3> corners;         // three of each triangle
    std::vector<std::uint32_t> faces;  // in which it lies
  };
  VoronoiRequest::Part part = VoronoiRequest::Part::cells;
  std::vector<DrawnCell> drawn_cells;
  Warnings warnings;
};

struct TraceReply {
  std::string mesh;
  ResolvedPoint from;
  ResolvedPoint to;       // where it ends
  double length = 0;      // that it has, mesh units
  std::string_view end;   // why it ends there
  Vec3 direction_at_end;  // of length one
  std::vector<PathReplyPoint> points;
  Warnings warnings;
};

struct LoopReply {
  std::string mesh;
  LoopRequest::Start start = LoopRequest::Start::plane;
  std::optional<Method> method;      // none of a plane
  std::vector<ResolvedPoint> asked;  // `through`, `around` or `at`
  std::optional<Vec3> normal;        // of a plane, as it was asked
  bool is_hull = false;
  double length = 0;           // mesh units
  double start_length = 0;     // of what it was made of, before it was tightened
  bool is_geodesic = false;    // locally shortest all round
  std::optional<double> turn;  // degrees: the most that it is off straight ahead; none of a hull
  Bound bound = Bound::none;   // upper: the length is rounded up where digits are cut
  std::vector<PathReplyPoint> points;  // the last one is the first
  Warnings warnings;
};

struct LogmapReply {
  std::string mesh;
  Method method = Method::wavefront;
  ResolvedPoint from;
  double angle = 0;        // of the x axis
  double radius = 0;       // that was asked for, or the greatest distance
  double total_angle = 0;  // of all directions at the point
  bool all_round = true;   // whether no boundary is in the way
  // For each source vertex that has a place, ascending:
  std::vector<std::uint32_t> vertices;
  std::vector<double> distances;
  std::vector<double> angles;                      // as TraceRequest has them
  std::vector<std::uint32_t> straight;             // 1: going straight ahead leads there; or 0
  std::vector<std::array<double, 2>> coordinates;  // mesh units
  // The x axis' direction carried along the path, of length one, or zeros; none: not asked for.
  std::optional<std::vector<std::array<double, 3>>> directions;
  Warnings warnings;
};

struct NearestReply {
  std::string mesh;
  std::vector<ResolvedPoint> points;
};

// `digits`: see append_number. Cut short, and no JSON, if the poll, where there is one, says to
// stop.
[[nodiscard]] std::string to_json(const DistanceReply& reply, int digits, Poll* poll = nullptr);
[[nodiscard]] std::string to_json(const PathReply& reply, int digits, Poll* poll = nullptr);
[[nodiscard]] std::string to_json(const TableReply& reply, int digits, Poll* poll = nullptr);
// A table in lines: the first one, with all but its rows, and one row, of which `sparse` has what
// is reached. `number`: of the row in the whole table.
// An object.
[[nodiscard]] std::string estimated_json(const Estimated& estimated);
[[nodiscard]] std::string first_line(const TableReply& reply, std::uint64_t first_row, int digits,
                                     Poll* poll = nullptr);
[[nodiscard]] std::string row_line(const TableReply& reply, std::size_t row, std::uint64_t number,
                                   std::span<const double> distances, bool sparse, int digits,
                                   Poll* poll = nullptr);
[[nodiscard]] std::string to_json(const IsolinesReply& reply, int digits, Poll* poll = nullptr);
[[nodiscard]] std::string to_json(const SamplesReply& reply, int digits, Poll* poll = nullptr);
[[nodiscard]] std::string to_json(const MeasureReply& reply, int digits, Poll* poll = nullptr);
[[nodiscard]] std::string to_json(const ExtentReply& reply, int digits, Poll* poll = nullptr);
[[nodiscard]] std::string to_json(const VoronoiReply& reply, int digits, Poll* poll = nullptr);
[[nodiscard]] std::string to_json(const TraceReply& reply, int digits, Poll* poll = nullptr);
[[nodiscard]] std::string to_json(const LoopReply& reply, int digits, Poll* poll = nullptr);
[[nodiscard]] std::string to_json(const LogmapReply& reply, int digits, Poll* poll = nullptr);
[[nodiscard]] std::string to_json(const NearestReply& reply, int digits, Poll* poll = nullptr);

}  // namespace geodesic::proto
