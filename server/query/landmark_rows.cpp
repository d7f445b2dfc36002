#include "server/query/landmark_rows.h"

#include <algorithm>
#include <utility>

#include "core/field/around_points.h"
#include "core/landmarks/spread_points.h"
#include "server/base/joint_caller.h"

namespace geodesic::server {
namespace {

// Whose whole fields estimates are compared with.
constexpr std::size_t kChecks = 8;

// Columns spread over all that are no landmarks.
std::vector<std::uint32_t> columns_to_check(std::size_t columns,
                                            std::span<const std::uint32_t> landmarks) {
  std::vector<bool> is_landmark(columns);
  for (const std::uint32_t l : landmarks) is_landmark[l] = true;
  std::vector<std::uint32_t> others;
  for (std::uint32_t c = 0; c < columns; ++c) {
    if (!is_landmark[c]) others.push_back(c);
  }
  std::vector<std::uint32_t> checked;
  const std::size_t count = std::min(kChecks, others.size());
  for (std::size_t i = 0; i < count; ++i) {
    checked.push_back(others[(2 * i + 1) * others.size() / (2 * count)]);
  }
  return checked;
}

proto::Estimated said_of(std::size_t landmarks, const EstimateErrors& errors) {
  return {landmarks, errors.mean, errors.percentile99, errors.max, errors.entries};
}

}  // namespace

std::uint64_t LandmarkRows::bytes(std::uint64_t landmarks, std::uint64_t rows,
                                  std::uint64_t columns) {
  // While it is made, the fields at all points; then of each row a distance, and of each column a
  // distance and a factor.
  constexpr std::uint64_t kOfFields = sizeof(double);
  constexpr std::uint64_t kOfRow = sizeof(double);
  constexpr std::uint64_t kOfColumn = 2 * sizeof(float);
  return (std::min(landmarks, columns) + kChecks) *
         ((rows + columns) * kOfFields + rows * kOfRow + columns * kOfColumn);
}

Result<std::shared_ptr<const LandmarkRows>> LandmarkRows::make(
    Fields& fields, ComputePool& pool, std::shared_ptr<const PointTable> table,
    std::uint64_t landmarks, proto::Estimated& estimated, const Caller& caller) {
  const Adjacency& adjacency = *table->question.adjacency;
  const std::size_t columns = table->to.size();
  const std::size_t rows = table->from.size();
  // Where distances are read: the columns, and behind them the rows.
  std::vector<SurfacePoint> points = table->to;
  const std::vector<SurfacePoint> of_rows = table->from.points();
  points.insert(points.end(), of_rows.begin(), of_rows.end());
  std::vector<std::uint32_t> faces;
  auto chosen = fields.compute_once(
      [&](SolveScratch&, const Cancel& cancel) -> Result<std::vector<std::uint32_t>> {
        auto around = faces_around(adjacency, points, cancel);
        if (!around) return fail(std::move(around.error()));
        faces = std::move(*around);
        // With details of one face at least, so that no bit depends on which rows are asked for:
        // `exact` rounds otherwise without any.
        if (faces.empty()) faces.push_back(0);
        return spread_points(adjacency, table->to, landmarks, cancel);
      },
      caller.part(0, 0));
  if (!chosen) return fail(std::move(chosen.error()));

  const std::vector<std::uint32_t> checked = columns_to_check(columns, *chosen);
  std::vector<Source> sources;
  for (const std::uint32_t c : *chosen) sources.push_back({table->to[c], 0});
  for (const std::uint32_t c : checked) sources.push_back({table->to[c], 0});
  const FieldRows from(sources);
  std::vector<std::vector<double>> distances(sources.size());
  // What has begun is not sent away for the queue's length.
  Caller of_fields = caller.part(0, 0);
  of_fields.is_patient = true;
  JointCaller joint(of_fields, sources.size());
  auto computed = pool.run_each(
      sources.size(),
      [&](Worker& worker, std::size_t i, const GiveWay& give_way) -> Result<void> {
        const JointCaller::Part part(joint, i);
        auto found =
            fields.row(table->question, from, i, points, faces, worker, give_way, part.caller());
        if (!found) return fail(std::move(found.error()));
        distances[i] = std::move(*found);
        return {};
      },
      of_fields);
  if (!computed) return fail(std::move(computed.error()));

  auto made = std::shared_ptr<LandmarkRows>();
  auto finished = fields.compute_once(
      [&](SolveScratch&, const Cancel& cancel) -> Result<void> {
        const std::size_t count = chosen->size();
        std::vector<double> to_landmarks(rows * count);
        Poll poll(cancel);
        for (std::size_t row = 0; row < rows; ++row) {
          if (poll.cancelled_after(count)) return fail_stopped(poll);
          for (std::size_t l = 0; l < count; ++l) {
            to_landmarks[row * count + l] = distances[l][columns + row];
          }
        }
        for (std::vector<double>& each : distances) each.resize(columns);
        auto known =
            LandmarkDistances::make(std::move(*chosen), std::span(distances).first(count), cancel);
        if (!known) return fail(std::move(known.error()));
        std::vector<KnownRow> checks;
        for (std::size_t i = 0; i < checked.size(); ++i) {
          KnownRow& row = checks.emplace_back();
          for (std::size_t l = 0; l < count; ++l) {
            row.to_landmarks.push_back(distances[l][checked[i]]);
          }
          row.to_points = std::move(distances[count + i]);
        }
        const auto errors = known->choose(checks, cancel);
        if (!errors) return fail(errors.error());
        estimated = said_of(count, *errors);
        made.reset(new LandmarkRows(fields, table, std::move(*known)));
        made->to_landmarks_ = std::move(to_landmarks);
        return {};
      },
      of_fields.finishing());
  if (!finished) return fail(std::move(finished.error()));
  return made;
}

Result<std::vector<double>> LandmarkRows::row(std::size_t number, Worker& worker,
                                              const GiveWay& give_way, const Caller& caller) const {
  const std::size_t count = known_.landmarks().size();
  const auto to_landmarks = std::span(to_landmarks_).subspan(number * count, count);
  FieldQuestion near = table_->question;
  near.max = known_.near(to_landmarks);
  auto found =
      fields_.row(near, table_->from, number, table_->to, table_->faces, worker, give_way, caller);
  if (!found) return found;
  const Cancel cancel([&] { return give_way() || caller(); });
  Poll poll(cancel);
  known_.estimate(to_landmarks, *found, poll);
  if (poll.stopped()) return fail_stopped(poll);
  return found;
}

}  // namespace geodesic::server
