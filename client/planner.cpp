// A planner in C++ with libzmq and ods_list.h. Prints a line of JSON for each list.
//
// c++ -std=c++17 -o planner planner.cpp -lzmq       (Debian: libzmq3-dev)
// ./planner RUN_DIR LISTS
#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>
#include <unistd.h>
#include <vector>
#include <zmq.h>

#include "ods_list.h"

struct Part {
    zmq_msg_t message;
    Part() { zmq_msg_init(&message); }
    ~Part() { zmq_msg_close(&message); }
    Part(const Part &) = delete;
    Part &operator=(const Part &) = delete;
    bool receive(void *socket) { return zmq_msg_recv(&message, socket, 0) >= 0; }
};

static void print(const OdsList &list, const std::vector<OdsObstacle> &obstacles) {
    std::cout << "{\"valid\": " << (list.valid ? "true" : "false") << ", \"utc_ns\": " << list.utc_ns;
    if (list.has_site) std::cout << ", \"site\": [" << list.latitude_deg << ", " << list.longitude_deg << "]";
    if (list.has_pose) std::cout << ", \"vehicle\": [" << list.position_ned[0] << ", " << list.position_ned[1] << "]";
    std::cout << ", \"ids\": [";
    const size_t count = std::min(list.obstacles, obstacles.size());
    for (size_t i = 0; i < count; i++) std::cout << (i ? ", " : "") << obstacles[i].id;
    std::cout << "], \"positions\": [";
    for (size_t i = 0; i < count; i++) {
        const double *p = obstacles[i].position_ned;
        std::cout << (i ? ", " : "") << "[" << p[0] << ", " << p[1] << ", " << p[2] << "]";
    }
    std::cout << "]}" << std::endl;
}

// Why nothing is heard: ZeroMQ tries again and again without a word, also where it has no right to the socket.
static const char *why_silent(const std::string &socket_file) {
    if (access(socket_file.c_str(), W_OK) == 0) return "the tracker is there, and silent";
    return errno == EACCES ? "no right to open the socket: join its group" : "no socket: does the tracker run?";
}

int main(int argc, char **argv) {
    if (argc != 3) return 2;
    const std::string file = std::string(argv[1]) + "/tracker.sock", address = "ipc://" + file;
    const int silence_ms = 1000;
    std::unique_ptr<void, int (*)(void *)> context(zmq_ctx_new(), zmq_ctx_term);
    std::unique_ptr<void, int (*)(void *)> socket(zmq_socket(context.get(), ZMQ_SUB), zmq_close);
    zmq_setsockopt(socket.get(), ZMQ_RCVTIMEO, &silence_ms, sizeof silence_ms);
    zmq_setsockopt(socket.get(), ZMQ_SUBSCRIBE, "obstacles", 9);
    if (zmq_connect(socket.get(), address.c_str())) return 1;
    std::vector<OdsObstacle> obstacles(1000);
    for (int left = std::atoi(argv[2]); left > 0; left--) {
        Part topic, body;
        OdsList list = OdsList();
        if (!topic.receive(socket.get()))
            std::cerr << file << ": " << why_silent(file) << std::endl;
        else if (body.receive(socket.get()))
            if (!ods_read_list(zmq_msg_data(&body.message), zmq_msg_size(&body.message), &list, obstacles.data(),
                               obstacles.size()))
                list = OdsList(); // of no use: as silence, it is no valid list
        print(list, obstacles);
    }
    return 0;
}
