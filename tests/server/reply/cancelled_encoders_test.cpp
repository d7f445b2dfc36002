// Whatever makes the bytes of a reply asks whether anybody waits for them, once in a bounded
// piece of its work: no matter how much work there is, it ends soon after nobody does.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/shapes.h"
#include "core/surface/adjacency.h"
#include "proto/encode/encode_geometry.h"
#include "server/http/gzip.h"
#include "server/reply/annotate_reply.h"
#include "server/reply/draw_reply.h"
#include "server/reply/encode_reply.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using namespace geodesic::server;
using proto::Format;

namespace {

// Makes a reply of so much work; only whether it was made is of interest.
using Encoder = std::function<Result<void>(std::size_t size, const Cancel& cancel)>;

struct Case {
  std::string what;
  Encoder encoder;
  std::size_t size;
};

template <class T>
Result<void> outcome(const Result<T>& result) {
  if (!result) return fail(result.error());
  return {};
}

std::shared_ptr<const Adjacency> adjacency_of(const TriangleSoup& soup) {
  auto mesh = Mesh::build(soup);
  REQUIRE(mesh);
  return std::make_shared<const Adjacency>(
      Adjacency::build(std::make_shared<const Mesh>(std::move(*mesh))));
}

// About so many vertices.
std::shared_ptr<const Adjacency> plane_of(std::size_t vertices) {
  return adjacency_of(shapes::plane(static_cast<std::uint32_t>(vertices / 10), 10));
}

// One face so many times.
std::shared_ptr<const Adjacency> heap_of(std::size_t faces) {
  TriangleSoup soup{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}};
  soup.faces.assign(faces, {0, 1, 2});
  return adjacency_of(soup);
}

proto::ReplyFormat in(Format format) {
  proto::ReplyFormat reply;
  reply.format = format;
  reply.picture.width = 200;
  reply.picture.height = 150;
  return reply;
}

Answered<proto::DistanceReply> distances_of(std::shared_ptr<const Adjacency> adjacency) {
  Answered<proto::DistanceReply> answer{};
  answer.reply.distances.assign(adjacency->mesh().source_vertex_count(), 1.25);
  answer.reply.max = 1.25;
  answer.reply.labels.emplace(answer.reply.distances.size(), 0);
  answer.adjacency = std::move(adjacency);
  return answer;
}

// A document with its values in it.
std::shared_ptr<const UploadedGltf> upload_of(std::uint64_t vertices) {
  UploadedGltf upload;
  upload.bytes = "{}";
  upload.annotation.json = "{}";
  upload.annotation.values_at = 1;
  upload.annotation.runs = {{0, vertices}};
  return std::make_shared<const UploadedGltf>(std::move(upload));
}

// To and fro over a square.
template <class Reply>
Answered<Reply> line_of(std::size_t points) {
  Answered<Reply> answer{};
  for (std::size_t i = 0; i < points; ++i) {
    const double x = static_cast<double>(i % 2);
    answer.reply.points.push_back({{x, x, 0}, 0, {1, 0, 0}});
  }
  answer.adjacency = adjacency_of(shapes::plane(2, 2));
  return answer;
}

std::vector<proto::ResolvedPoint> points_of(std::size_t count) {
  proto::ResolvedPoint point;
  point.vertex = 1;
  return std::vector<proto::ResolvedPoint>(count, point);
}

Answered<proto::IsolinesReply> isolines_of(std::size_t count) {
  Answered<proto::IsolinesReply> answer{};
  Isoline line;
  line.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  line.closed = true;
  answer.reply.isolines.assign(count, line);
  return answer;
}

std::vector<Case> encoders() {
  constexpr std::size_t kNumbers = 20'000;
  std::vector<Case> cases;
  for (const Format format :
       {Format::json, Format::f32, Format::f64, Format::u16, Format::npy, Format::frame}) {
    const std::string name(proto::name_of(format));
    cases.push_back({"distances as " + name,
                     [=](std::size_t n, const Cancel& cancel) {
                       return outcome(encode(distances_of(plane_of(n)), in(format), cancel));
                     },
                     kNumbers});
    cases.push_back({"a table as " + name,
                     [=](std::size_t n, const Cancel& cancel) {
                       Answered<proto::TableReply> answer{};
                       answer.reply.rows = points_of(n / 10);
                       answer.reply.columns = points_of(10);
                       answer.reply.distances.assign(n, 0.5);
                       return outcome(encode(std::move(answer), in(format), cancel));
                     },
                     kNumbers});
    if (format == Format::u16) continue;
    cases.push_back({"a path as " + name,
                     [=](std::size_t n, const Cancel& cancel) {
                       return outcome(encode(line_of<proto::PathReply>(n), in(format), cancel));
                     },
                     kNumbers});
    cases.push_back({"a trace as " + name,
                     [=](std::size_t n, const Cancel& cancel) {
                       return outcome(encode(line_of<proto::TraceReply>(n), in(format), cancel));
                     },
                     kNumbers});
  }
  cases.push_back({"isolines as JSON",
                   [](std::size_t n, const Cancel& cancel) {
                     return outcome(encode(isolines_of(n), in(Format::json), cancel));
                   },
                   kNumbers});
  cases.push_back({"samples as JSON",
                   [](std::size_t n, const Cancel& cancel) {
                     Answered<proto::SamplesReply> answer{};
                     answer.reply.samples.resize(n);
                     return outcome(encode(std::move(answer), in(Format::json), cancel));
                   },
                   kNumbers});
  cases.push_back({"points as JSON",
                   [](std::size_t n, const Cancel& cancel) {
                     Answered<proto::NearestReply> answer{};
                     answer.reply.points = points_of(n);
                     return outcome(encode(std::move(answer), in(Format::json), cancel));
                   },
                   kNumbers});
  cases.push_back({"distances as GLB",
                   [](std::size_t n, const Cancel& cancel) {
                     return outcome(draw(distances_of(plane_of(n)), in(Format::glb), cancel));
                   },
                   kNumbers});
  cases.push_back({"a path as GLB",
                   [](std::size_t n, const Cancel& cancel) {
                     return outcome(draw(line_of<proto::PathReply>(n), in(Format::glb), cancel));
                   },
                   kNumbers});
  cases.push_back({"isolines as GLB",
                   [](std::size_t n, const Cancel& cancel) {
                     return outcome(draw(isolines_of(n), in(Format::glb), cancel));
                   },
                   5'000});
  cases.push_back({"distances in their file",
                   [](std::size_t n, const Cancel& cancel) {
                     auto answer = distances_of(plane_of(n));
                     answer.upload = upload_of(answer.reply.distances.size());
                     return outcome(annotate(std::move(answer), in(Format::annotated), cancel));
                   },
                   kNumbers});
  cases.push_back({"a map in its file",
                   [](std::size_t n, const Cancel& cancel) {
                     Answered<proto::LogmapReply> answer{};
                     answer.adjacency = plane_of(n);
                     const std::uint32_t count = answer.adjacency->mesh().source_vertex_count();
                     answer.reply.distances.assign(count, 1.25);
                     answer.reply.coordinates.assign(count, {0.75, 1});
                     for (std::uint32_t v = 0; v < count; ++v) answer.reply.vertices.push_back(v);
                     answer.upload = upload_of(count);
                     return outcome(annotate(std::move(answer), in(Format::annotated), cancel));
                   },
                   kNumbers});
  cases.push_back({"faces in one place as PNG",
                   [](std::size_t n, const Cancel& cancel) {
                     return outcome(draw(distances_of(heap_of(n)), in(Format::png), cancel));
                   },
                   30});
  cases.push_back({"many faces as PNG",
                   [](std::size_t n, const Cancel& cancel) {
                     return outcome(draw(distances_of(plane_of(n)), in(Format::png), cancel));
                   },
                   50'000});
  cases.push_back({"a path over one place as PNG",
                   [](std::size_t n, const Cancel& cancel) {
                     return outcome(draw(line_of<proto::PathReply>(n), in(Format::png), cancel));
                   },
                   20});
  cases.push_back({"a trace over one place as PNG",
                   [](std::size_t n, const Cancel& cancel) {
                     return outcome(draw(line_of<proto::TraceReply>(n), in(Format::png), cancel));
                   },
                   20});
  cases.push_back({"marks in one place as PNG",
                   [](std::size_t n, const Cancel& cancel) {
                     auto answer = distances_of(heap_of(1));
                     answer.reply.from = points_of(n);
                     return outcome(draw(answer, in(Format::png), cancel));
                   },
                   2'000});
  cases.push_back({"the pixels of a PNG",
                   [](std::size_t n, const Cancel& cancel) {
                     proto::ReplyFormat format = in(Format::png);
                     format.picture.width = 256;
                     format.picture.height = static_cast<std::uint32_t>(n);
                     return outcome(draw(distances_of(heap_of(1)), format, cancel));
                   },
                   256});
  cases.push_back({"a geometry as GLB",
                   [](std::size_t n, const Cancel& cancel) {
                     Poll poll(cancel);
                     return outcome(proto::geometry_glb(plane_of(n)->mesh(), poll));
                   },
                   kNumbers});
  cases.push_back({"a geometry as a frame",
                   [](std::size_t n, const Cancel& cancel) {
                     Poll poll(cancel);
                     return outcome(proto::geometry_frame("id", plane_of(n)->mesh(), poll));
                   },
                   kNumbers});
  cases.push_back({"gzip",
                   [](std::size_t n, const Cancel& cancel) -> Result<void> {
                     Poll poll(cancel);
                     (void)gzip(std::string(n, 'a'), &poll);
                     if (poll.stopped()) return fail_stopped(poll);
                     return {};
                   },
                   2U << 20});
  return cases;
}

}  // namespace

TEST_CASE("EveryEncoderAsksInBoundedPiecesOfItsWorkAndEndsWhenItIsTold") {
  std::vector<Case> all = encoders();
  std::shuffle(all.begin(), all.end(), std::mt19937(fixtures::test_seed()));
  all.resize(fixtures::all_or(all.size(), all.size() / 4));
  for (const Case& one : all) {
    CAPTURE(one.what);
    const auto asked_for = [&](std::size_t size) {
      std::size_t asked = 0;
      CHECK(one.encoder(size, Cancel([&] { return ++asked == 0; })));
      return asked;
    };
    const std::size_t asked = asked_for(one.size);
    CHECK(asked >= 2);
    // Eight times the work, about eight times the questions.
    CHECK(asked_for(8 * one.size) >= 4 * asked);
    for (const std::size_t last : {std::size_t{1}, std::size_t{2}, asked / 2, asked}) {
      std::size_t now = 0;
      const auto ended = one.encoder(one.size, Cancel([&] { return ++now >= last; }));
      REQUIRE_FALSE(ended);
      CHECK(ended.error().code == ErrorCode::cancelled);
      CHECK(now == std::max<std::size_t>(last, 1));
    }
  }
}
