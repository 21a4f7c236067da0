/* A planner in C with libzmq, and the few lines of msgpack that it takes. Prints a line of JSON for each list.
 *
 * cc -o planner planner.c -lzmq       (Debian: libzmq3-dev)
 * ./planner RUN_DIR LISTS
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zmq.h>

typedef struct { const unsigned char *at, *end; } Reader;
typedef enum { NOTHING, NUMBER, TEXT, LIST, MAP } Kind;
typedef struct { Kind kind; double number; uint32_t count; const char *text; } Value; /* count: items, pairs or bytes */

static uint64_t big_endian(Reader *r, int bytes) {
    uint64_t n = 0;
    if (r->end - r->at < bytes) exit(2);
    while (bytes--) n = n << 8 | *r->at++;
    return n;
}

static Value text(Reader *r, uint64_t length) {
    Value v = {TEXT, 0.0, (uint32_t)length, (const char *)r->at};
    if ((uint64_t)(r->end - r->at) < length) exit(2);
    r->at += length;
    return v;
}

/* The head of the next value; items of lists and maps follow as values of their own. */
static Value next(Reader *r) {
    Value v = {NOTHING, 0.0, 0, NULL};
    unsigned c = (unsigned)big_endian(r, 1);
    if (c < 0x80 || c >= 0xe0) { v.kind = NUMBER; v.number = (signed char)c; return v; }
    if (c < 0x90) { v.kind = MAP; v.count = c & 0x0f; return v; }
    if (c < 0xa0) { v.kind = LIST; v.count = c & 0x0f; return v; }
    if (c < 0xc0) return text(r, c & 0x1f);
    if (c == 0xc2 || c == 0xc3) { v.kind = NUMBER; v.number = c & 1; return v; }
    if (c == 0xca) { uint32_t u = (uint32_t)big_endian(r, 4); float f; memcpy(&f, &u, 4); v.kind = NUMBER; v.number = f; }
    if (c == 0xcb) { uint64_t u = big_endian(r, 8); v.kind = NUMBER; memcpy(&v.number, &u, 8); }
    if (c >= 0xcc && c <= 0xcf) { v.kind = NUMBER; v.number = (double)big_endian(r, 1 << (c - 0xcc)); }
    if (c >= 0xd0 && c <= 0xd3) {
        int bytes = 1 << (c - 0xd0);
        v.kind = NUMBER;
        v.number = (double)((int64_t)(big_endian(r, bytes) << (64 - 8 * bytes)) >> (64 - 8 * bytes));
    }
    if (c >= 0xd9 && c <= 0xdb) return text(r, big_endian(r, 1 << (c - 0xd9)));
    if (c >= 0xdc && c <= 0xdf) { v.kind = c < 0xde ? LIST : MAP; v.count = (uint32_t)big_endian(r, c & 1 ? 4 : 2); }
    return v;
}

static void skip(Reader *r) {
    Value v = next(r);
    uint32_t items = v.kind == LIST ? v.count : v.kind == MAP ? 2 * v.count : 0;
    while (items--) skip(r);
}

static int is(Value v, const char *word) {
    return v.kind == TEXT && v.count == strlen(word) && !memcmp(v.text, word, v.count);
}

/* Print position_ned of one obstacle. */
static void print_position(Reader *r, int first) {
    uint32_t pairs = next(r).count;
    while (pairs--) {
        if (!is(next(r), "position_ned")) { skip(r); continue; }
        next(r);
        double north = next(r).number, east = next(r).number, down = next(r).number;
        printf("%s[%.3f, %.3f, %.3f]", first ? "" : ", ", north, east, down);
    }
}

static void print_list(Reader r) {
    uint32_t pairs = next(&r).count;
    int valid = 0;
    Reader obstacles = {NULL, NULL};
    while (pairs--) {
        Value key = next(&r);
        if (is(key, "valid")) { valid = next(&r).number != 0.0; continue; }
        if (is(key, "obstacles")) obstacles = r;
        skip(&r);
    }
    printf("{\"valid\": %s, \"positions\": [", valid ? "true" : "false");
    uint32_t count = obstacles.at ? next(&obstacles).count : 0;
    for (uint32_t i = 0; i < count; i++) print_position(&obstacles, i == 0);
    printf("]}\n");
    fflush(stdout);
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
            zmq_msg_close(&topic);
            continue;
        }
        zmq_msg_init(&body);
        zmq_msg_recv(&body, socket, 0);
        const unsigned char *bytes = zmq_msg_data(&body);
        print_list((Reader){bytes, bytes + zmq_msg_size(&body)});
        zmq_msg_close(&topic);
        zmq_msg_close(&body);
    }
    return 0;
}
