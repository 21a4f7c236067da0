/* A planner in C with libzmq and client/ods_list.h. Prints a line of JSON for each list.
 *
 * cc -I../../../client -o planner planner.c -lzmq       (Debian: libzmq3-dev)
 * ./planner RUN_DIR LISTS
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>
#include <zmq.h>

#include "ods_list.h"

#define ROOM 1000

static OdsObstacle obstacles[ROOM];

static void print_list(const void *bytes, size_t size) {
    OdsList list;
    if (!ods_read_list(bytes, size, &list, obstacles, ROOM)) memset(&list, 0, sizeof list); /* as silence: not valid */
    printf("{\"valid\": %s, \"positions\": [", list.valid ? "true" : "false");
    for (size_t i = 0; i < list.obstacles && i < ROOM; i++) {
        const double *p = obstacles[i].position_ned;
        printf("%s[%.3f, %.3f, %.3f]", i ? ", " : "", p[0], p[1], p[2]);
    }
    printf("]}\n");
    fflush(stdout);
}

/* Why nothing is received: ZeroMQ tries again and again without a word, also where it has no right to the socket. */
static const char *why_silent(const char *socket_file) {
    if (access(socket_file, W_OK) == 0) return "the tracker is there, and silent";
    return errno == EACCES ? "no right to open the socket: join its group" : "no socket: does the tracker run?";
}

int main(int argc, char **argv) {
    if (argc != 3) return 2;
    char address[200];
    int silence_ms = 1000;
    void *context = zmq_ctx_new(), *socket = zmq_socket(context, ZMQ_SUB);
    snprintf(address, sizeof address, "ipc://%s/tracker.sock", argv[1]);
    zmq_setsockopt(socket, ZMQ_RCVTIMEO, &silence_ms, sizeof silence_ms);
    zmq_setsockopt(socket, ZMQ_SUBSCRIBE, "obstacles", 9);
    if (zmq_connect(socket, address)) return 1;
    for (int left = atoi(argv[2]); left > 0; left--) {
        zmq_msg_t topic, body;
        zmq_msg_init(&topic);
        if (zmq_msg_recv(&topic, socket, 0) < 0) {
            printf("{\"valid\": false, \"positions\": []}\n"); /* silence is an answer, too */
            fflush(stdout);
            fprintf(stderr, "%s: %s\n", address + 6, why_silent(address + 6));
            zmq_msg_close(&topic);
            continue;
        }
        zmq_msg_init(&body);
        zmq_msg_recv(&body, socket, 0);
        print_list(zmq_msg_data(&body), zmq_msg_size(&body));
        zmq_msg_close(&topic);
        zmq_msg_close(&body);
    }
    return 0;
}
