// How much memory replies take, estimated before they are made.
#include <algorithm>

#include "server/reply/draw_reply.h"
#include "server/reply/encode_reply.h"

namespace geodesic::server {
namespace {

using proto::Format;

// Of a point as a reply echoes it: its face, weights and coordinates, and some for their names.
constexpr std::uint64_t kNumbersOfPoint = 12;
// Of a point of a path or of a trace.
constexpr std::uint64_t kNumbersOfLinePoint = 9;

template <class Reply>
ReplySize size_by(std::uint64_t numbers, const Answered<Reply>& answer,
                  const proto::ReplyFormat& format, std::uint64_t floats_of_vertex = 3) {
  // The number itself, its text of at most 25 characters, and about as much for that in gzip.
  constexpr std::uint64_t kJson = 8 + 25 + 25;
  // The number, its encoded bytes, and these once more with a header before them.
  constexpr std::uint64_t kBinary = 3 * 8;
  constexpr std::uint64_t kRest = 4096;
  const Mesh& mesh = answer.adjacency->mesh();
  switch (format.format) {
    case Format::json:
      return {numbers, numbers * kJson + kRest};
    case Format::png:
      // A value a vertex, what is seen of it, and some layers of the picture.
      return {numbers, numbers * kBinary + std::uint64_t{64} * mesh.vertex_count() +
                           std::uint64_t{32} * format.picture.width * format.picture.height};
    case Format::glb:
      // Positions, colours and indices, and twice their bytes.
      return {numbers,
              numbers * (kBinary + 3 * 24) +
                  std::uint64_t{100} * std::max(mesh.source_vertex_count(), mesh.vertex_count()) +
                  std::uint64_t{36} * mesh.face_count() + kRest};
    case Format::annotated:
      // The floats of each vertex, at most, and the doubles that they are made of.
      return {numbers, numbers * kBinary +
                           12 * floats_of_vertex * std::uint64_t{mesh.source_vertex_count()} +
                           answer.upload->bytes_to_write(floats_of_vertex) + kRest};
    default:
      return {numbers, numbers * kBinary + kRest};
  }
}

}  // namespace

ReplySize size_of(const Answered<proto::DistanceReply>& answer, const proto::ReplyFormat& format) {
  const proto::DistanceReply& reply = answer.reply;
  std::uint64_t numbers = answer.numbers + reply.distances.size();
  if (reply.labels) numbers += reply.labels->size();
  if (reply.at) numbers += kNumbersOfPoint * reply.at->size();
  return size_by(numbers + kNumbersOfPoint * reply.from.size(), answer, format);
}

ReplySize size_of(const Answered<proto::PathReply>& answer, const proto::ReplyFormat& format) {
  // With costs, a length and a cost of each segment.
  const std::uint64_t of_point = kNumbersOfLinePoint + (answer.reply.costs ? 2 : 0);
  return size_by(
      of_point * answer.reply.points.size() + kNumbersOfPoint * (answer.reply.via.size() + 2),
      answer, format);
}

ReplySize size_of(const Answered<proto::TraceReply>& answer, const proto::ReplyFormat& format) {
  return size_by(kNumbersOfLinePoint * answer.reply.points.size(), answer, format);
}

ReplySize size_of(const Answered<proto::TableReply>& answer, const proto::ReplyFormat& format) {
  const proto::TableReply& reply = answer.reply;
  // An entry of a sparse one has its column and its distance.
  const std::uint64_t entries = reply.sparse ? 2 * reply.sparse->count() : 0;
  return size_by(entries + reply.distances.size() +
                     kNumbersOfPoint * (reply.rows.size() + reply.columns.size()),
                 answer, format);
}

ReplySize size_of(const Answered<proto::IsolinesReply>& answer, const proto::ReplyFormat& format) {
  std::uint64_t numbers = answer.reply.levels.size();
  for (const Isoline& line : answer.reply.isolines) numbers += 4 + 3 * line.points.size();
  return size_by(numbers, answer, format);
}

ReplySize size_of(const Answered<proto::SamplesReply>& answer, const proto::ReplyFormat& format) {
  return size_by(kNumbersOfPoint * (answer.reply.samples.size() + answer.reply.from.size()), answer,
                 format);
}

ReplySize size_of(const Answered<proto::MeasureReply>& answer, const proto::ReplyFormat& format) {
  constexpr std::uint64_t kNumbersOfDisc = 9;
  const std::uint64_t drawn = format.format == Format::glb ? answer.drawn_numbers : 0;
  return size_by(drawn + kNumbersOfDisc * answer.reply.discs.size() +
                     kNumbersOfPoint * answer.reply.from.size(),
                 answer, format);
}

ReplySize size_of(const Answered<proto::ExtentReply>& answer, const proto::ReplyFormat& format) {
  return size_by(kNumbersOfPoint * answer.reply.vertices.size() + answer.numbers, answer, format);
}

ReplySize size_of(const Answered<proto::VoronoiReply>& answer, const proto::ReplyFormat& format) {
  const proto::VoronoiReply& reply = answer.reply;
  // A cell has its site and its centroid, and a triangle its point.
  std::uint64_t numbers = (3 * reply.cells.size() + 2 * reply.triangles.size()) * kNumbersOfPoint +
                          3 * reply.neighbours.size();
  for (const Bisector& line : reply.bisectors) numbers += 5 + 3 * line.points.size();
  if (format.format == Format::glb) numbers += answer.drawn_numbers;
  return size_by(numbers, answer, format);
}

ReplySize size_of(const Answered<proto::LoopReply>& answer, const proto::ReplyFormat& format) {
  return size_by(kNumbersOfLinePoint * answer.reply.points.size() +
                     kNumbersOfPoint * answer.reply.asked.size(),
                 answer, format);
}

ReplySize size_of(const Answered<proto::LogmapReply>& answer, const proto::ReplyFormat& format) {
  return size_by(answer.numbers + kNumbersOfPoint, answer, format, answer.reply.directions ? 6 : 3);
}

ReplySize size_of(const Answered<proto::NearestReply>& answer, const proto::ReplyFormat& format) {
  return size_by(kNumbersOfPoint * answer.reply.points.size(), answer, format);
}

}  // namespace geodesic::server
