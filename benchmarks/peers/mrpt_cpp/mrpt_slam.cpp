// EKF-SLAM with MRPT's CRangeBearingKFSLAM2D on steps that are read from a file; known ids, an empty map at the start.
//
//   mrpt_slam naive|davison STEPS ANSWER SHORT
//
// STEPS   number of steps, range std, bearing std, the sensor's reach; then for each step "dx dy dtheta", the nine numbers
//         of the covariance of that motion, the number of measurements, and "id range bearing" for each of them
// ANSWER  for each step the nanoseconds of thread CPU that it took; then the robot's pose and its covariance
//
// SHORT   nanoseconds: a shorter run is done twice and the second time counts, as in circuit.py
//
// Timed is processActionObservation alone: the containers that it takes are made before.
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservationBearingRange.h>
#include <mrpt/slam/CRangeBearingKFSLAM2D.h>

#include <cmath>
#include <ctime>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

using namespace mrpt;

static long long thread_ns() {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

static obs::CActionCollection::Ptr read_motion(std::istream &in) {
    auto motion = std::make_shared<poses::CPosePDFGaussian>();
    double dx, dy, turn;
    in >> dx >> dy >> turn;
    motion->mean = poses::CPose2D(dx, dy, turn);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) in >> motion->cov(i, j);
    obs::CActionRobotMovement2D move;
    move.estimationMethod = obs::CActionRobotMovement2D::emOdometry;
    move.poseChange.get_ptr() = motion;
    auto actions = obs::CActionCollection::Create();
    actions->insert(move);
    return actions;
}

// The sensor sees all around. MRPT has to know: it predicts what can be in view, and does it again if it was mistaken.
static obs::CSensoryFrame::Ptr read_sight(std::istream &in, double reach) {
    auto seen = obs::CObservationBearingRange::Create();
    seen->validCovariances = false;
    seen->maxSensorDistance = reach;
    seen->fieldOfView_yaw = 2 * M_PI;
    int m;
    in >> m;
    for (int i = 0; i < m; ++i) {
        obs::CObservationBearingRange::TMeasurement y;
        in >> y.landmarkID >> y.range >> y.yaw;
        y.pitch = 0;
        seen->sensedData.push_back(y);
    }
    auto frame = obs::CSensoryFrame::Create();
    frame->insert(seen);
    return frame;
}

int main(int argc, char **argv) {
    if (argc != 5) return std::cerr << "usage: mrpt_slam naive|davison STEPS ANSWER SHORT\n", 2;
    std::ifstream in(argv[2]);
    std::ofstream out(argv[3]);
    int n_steps;
    double std_range, std_bearing, reach;
    in >> n_steps >> std_range >> std_bearing >> reach;
    std::vector<obs::CActionCollection::Ptr> actions;
    std::vector<obs::CSensoryFrame::Ptr> frames;
    for (int k = 0; k < n_steps; ++k) {
        actions.push_back(read_motion(in));
        frames.push_back(read_sight(in, reach));
    }

    std::optional<slam::CRangeBearingKFSLAM2D> filter;
    std::vector<long long> times(n_steps);
    for (int round = 0; round < 2; ++round) {
        filter.emplace();
        filter->options.std_sensor_range = std_range;
        filter->options.std_sensor_yaw = std_bearing;
        filter->KF_options.method = std::string(argv[1]) == "naive" ? bayes::kfEKFNaive : bayes::kfEKFAlaDavison;
        for (int k = 0; k < n_steps; ++k) {
            const auto start = thread_ns();
            filter->processActionObservation(actions[k], frames[k]);
            times[k] = thread_ns() - start;
        }
        if (std::accumulate(times.begin(), times.end(), 0LL) > std::stoll(argv[4])) break;
    }
    for (auto t : times) out << t << "\n";
    poses::CPosePDFGaussian pose;
    filter->getCurrentRobotPose(pose);
    out << std::setprecision(17) << pose.mean.x() << " " << pose.mean.y() << " " << pose.mean.phi() << "\n" << pose.cov << "\n";
    return in ? 0 : 1;
}
