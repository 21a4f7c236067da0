/* Obstacle lists of ODS for C99 and C++: reads the msgpack of the topic `obstacles` (docs/messages/README.md, ObstacleList).
 *
 * One header, nothing but libc, no memory of its own. What comes from the wire is not trusted: a message that is cut
 * short, nested too deep or of other types is refused, and fields that are not known here are passed over.
 */
#ifndef ODS_LIST_H
#define ODS_LIST_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define ODS_REASON_BYTES 256

typedef enum { ODS_ACTIVE, ODS_STAND_BY, ODS_HIBERNATED, ODS_TERMINATED, ODS_OTHER_STATE } OdsState;

typedef struct { /* m, m/s; north east down; sigma: standard deviations */
    int64_t id;
    OdsState state;
    double position_ned[3], sigma_position[3], covariance_ne;
    double velocity_ned[3], sigma_velocity[3];
    double radius_m, sigma_radius, existence;
    int64_t first_seen_utc_ns, last_seen_utc_ns;
    int64_t ignored_by;            /* number of the operator's veto by which it may be ignored; below 0: none */
} OdsObstacle;

typedef struct {
    int valid;                     /* 0: do not rely on it to be complete */
    char reason[ODS_REASON_BYTES]; /* the first one why not, cut to fit; "" if it is valid */
    int64_t seq, ping_number;
    int64_t t_ns, utc_ns;           /* of the ping: CLOCK_MONOTONIC of the vehicle's computer, and UTC */
    int64_t made_ns, made_utc_ns;   /* of the list: how old it is */
    int has_site, has_pose;         /* 0: what follows of it is 0 */
    double latitude_deg, longitude_deg;
    double position_ned[3], attitude[4], vehicle_velocity_ned[3]; /* of the vehicle; attitude: w, x, y, z */
    uint64_t left_out;              /* obstacles farther away that are not in the message */
    size_t obstacles;               /* in the message, whatever room there was for them */
} OdsList;

/* ---- msgpack ---- */

typedef struct { const unsigned char *at, *end; int bad; } OdsReader;
typedef enum { ODS_NIL, ODS_NUMBER, ODS_TEXT, ODS_LIST, ODS_MAP, ODS_BYTES } OdsKind;
typedef struct { OdsKind kind; double real; int64_t whole; uint32_t count; const char *text; } OdsValue;

static inline uint64_t ods_big_endian(OdsReader *r, int bytes) {
    uint64_t n = 0;
    if (r->end - r->at < bytes) { r->bad = 1; return 0; }
    while (bytes--) n = n << 8 | *r->at++;
    return n;
}

static inline OdsValue ods_number(OdsValue v, double real, int64_t whole) {
    v.kind = ODS_NUMBER;
    v.real = real;
    v.whole = whole;
    return v;
}

static inline OdsValue ods_run(OdsReader *r, OdsValue v, OdsKind kind, uint64_t length) {
    if ((uint64_t)(r->end - r->at) < length) { r->bad = 1; return v; }
    v.kind = kind;
    v.count = (uint32_t)length;
    v.text = (const char *)r->at;
    r->at += length;
    return v;
}

/* The head of the next value; items of lists and pairs of maps follow as values of their own. */
static inline OdsValue ods_next(OdsReader *r) {
    OdsValue v = {ODS_NIL, 0.0, 0, 0, NULL};
    unsigned c = (unsigned)ods_big_endian(r, 1);
    if (r->bad || c == 0xc0) return v;
    if (c < 0x80 || c >= 0xe0) return ods_number(v, (signed char)c, (signed char)c);
    if (c < 0xa0 || (c >= 0xdc && c <= 0xdf)) {
        v.kind = c < 0x90 || c >= 0xde ? ODS_MAP : ODS_LIST;
        v.count = c < 0xa0 ? c & 0x0f : (uint32_t)ods_big_endian(r, c & 1 ? 4 : 2);
        return v;
    }
    if (c < 0xc0) return ods_run(r, v, ODS_TEXT, c & 0x1f);
    if (c == 0xc2 || c == 0xc3) return ods_number(v, c & 1, c & 1);
    if (c >= 0xc4 && c <= 0xc6) return ods_run(r, v, ODS_BYTES, ods_big_endian(r, 1 << (c - 0xc4)));
    if (c >= 0xd9 && c <= 0xdb) return ods_run(r, v, ODS_TEXT, ods_big_endian(r, 1 << (c - 0xd9)));
    if (c == 0xca) {
        uint32_t bits = (uint32_t)ods_big_endian(r, 4);
        float f;
        memcpy(&f, &bits, 4);
        return ods_number(v, f, 0);
    }
    if (c == 0xcb) {
        uint64_t bits = ods_big_endian(r, 8);
        double d;
        memcpy(&d, &bits, 8);
        return ods_number(v, d, 0);
    }
    if (c >= 0xcc && c <= 0xcf) {
        uint64_t n = ods_big_endian(r, 1 << (c - 0xcc));
        return ods_number(v, (double)n, (int64_t)n);
    }
    if (c >= 0xd0 && c <= 0xd3) {
        int bytes = 1 << (c - 0xd0);
        uint64_t n = ods_big_endian(r, bytes), sign = (uint64_t)1 << (8 * bytes - 1);
        int64_t whole = (int64_t)((n ^ sign) - sign);
        return ods_number(v, (double)whole, whole);
    }
    r->bad = 1; /* extensions: no message has any */
    return v;
}

static inline void ods_skip(OdsReader *r) {
    uint64_t left = 1; /* without recursion: depth costs nothing */
    while (left-- && !r->bad) {
        OdsValue v = ods_next(r);
        if (v.kind == ODS_LIST) left += v.count;
        if (v.kind == ODS_MAP) left += 2 * (uint64_t)v.count;
    }
}

static inline int ods_is(OdsValue v, const char *word) {
    return v.kind == ODS_TEXT && v.count == strlen(word) && !memcmp(v.text, word, v.count);
}

static inline double ods_real(OdsReader *r) {
    OdsValue v = ods_next(r);
    if (v.kind != ODS_NUMBER || !isfinite(v.real)) r->bad = 1;
    return r->bad ? 0.0 : v.real;
}

static inline int64_t ods_whole(OdsReader *r) {
    OdsValue v = ods_next(r);
    if (v.kind != ODS_NUMBER) r->bad = 1;
    return r->bad ? 0 : v.whole;
}

static inline void ods_reals(OdsReader *r, double *out, uint32_t count) {
    OdsValue v = ods_next(r);
    if (v.kind != ODS_LIST || v.count != count) { r->bad = 1; return; }
    for (uint32_t i = 0; i < count; i++) out[i] = ods_real(r);
}

static inline uint32_t ods_count(OdsReader *r, OdsKind kind) {
    OdsValue v = ods_next(r);
    if (v.kind != kind) r->bad = 1;
    return r->bad ? 0 : v.count;
}

/* ---- lists ---- */

static inline OdsState ods_state(OdsValue v) {
    static const char *const names[] = {"active", "stand_by", "hibernated", "terminated"};
    int i = 0;
    while (i < 4 && !ods_is(v, names[i])) i++;
    return (OdsState)i;
}

static inline void ods_read_obstacle(OdsReader *r, OdsObstacle *o) {
    memset(o, 0, sizeof *o);
    o->ignored_by = -1;
    for (uint32_t pairs = ods_count(r, ODS_MAP); pairs && !r->bad; pairs--) {
        OdsValue key = ods_next(r);
        if (ods_is(key, "id")) o->id = ods_whole(r);
        else if (ods_is(key, "state")) o->state = ods_state(ods_next(r));
        else if (ods_is(key, "position_ned")) ods_reals(r, o->position_ned, 3);
        else if (ods_is(key, "sigma_position")) ods_reals(r, o->sigma_position, 3);
        else if (ods_is(key, "velocity_ned")) ods_reals(r, o->velocity_ned, 3);
        else if (ods_is(key, "sigma_velocity")) ods_reals(r, o->sigma_velocity, 3);
        else if (ods_is(key, "covariance_ne")) o->covariance_ne = ods_real(r);
        else if (ods_is(key, "radius_m")) o->radius_m = ods_real(r);
        else if (ods_is(key, "sigma_radius")) o->sigma_radius = ods_real(r);
        else if (ods_is(key, "existence")) o->existence = ods_real(r);
        else if (ods_is(key, "first_seen_utc_ns")) o->first_seen_utc_ns = ods_whole(r);
        else if (ods_is(key, "last_seen_utc_ns")) o->last_seen_utc_ns = ods_whole(r);
        else if (ods_is(key, "ignored_by")) o->ignored_by = ods_whole(r);
        else ods_skip(r);
    }
}

static inline void ods_read_reasons(OdsReader *r, OdsList *list) {
    uint32_t count = ods_count(r, ODS_LIST);
    for (uint32_t i = 0; i < count && !r->bad; i++) {
        OdsValue v = ods_next(r);
        if (v.kind != ODS_TEXT) { r->bad = 1; return; }
        if (i) continue;
        size_t bytes = v.count < ODS_REASON_BYTES - 1 ? v.count : ODS_REASON_BYTES - 1;
        memcpy(list->reason, v.text, bytes);
        list->reason[bytes] = 0;
    }
}

static inline void ods_read_site(OdsReader *r, OdsList *list) {
    OdsValue v = ods_next(r);
    if (v.kind == ODS_NIL) return;
    if (v.kind != ODS_MAP) { r->bad = 1; return; }
    list->has_site = 1;
    for (uint32_t pairs = v.count; pairs && !r->bad; pairs--) {
        OdsValue key = ods_next(r);
        if (ods_is(key, "latitude_deg")) list->latitude_deg = ods_real(r);
        else if (ods_is(key, "longitude_deg")) list->longitude_deg = ods_real(r);
        else ods_skip(r);
    }
}

static inline void ods_read_pose(OdsReader *r, OdsList *list) {
    OdsValue v = ods_next(r);
    if (v.kind == ODS_NIL) return;
    if (v.kind != ODS_MAP) { r->bad = 1; return; }
    list->has_pose = 1;
    for (uint32_t pairs = v.count; pairs && !r->bad; pairs--) {
        OdsValue key = ods_next(r);
        if (ods_is(key, "position_ned")) ods_reals(r, list->position_ned, 3);
        else if (ods_is(key, "attitude")) ods_reals(r, list->attitude, 4);
        else if (ods_is(key, "velocity_ned")) ods_reals(r, list->vehicle_velocity_ned, 3);
        else ods_skip(r);
    }
}

/* Read one message. Up to `room` obstacles are stored, in the order of the list. Returns 1; 0 for a message that is
 * none: then nothing of `list` may be used. */
static inline int ods_read_list(const void *bytes, size_t size, OdsList *list, OdsObstacle *obstacles, size_t room) {
    OdsReader reader = {(const unsigned char *)bytes, (const unsigned char *)bytes + size, 0}, *r = &reader;
    int told_valid = 0, told_obstacles = 0;
    memset(list, 0, sizeof *list);
    for (uint32_t pairs = ods_count(r, ODS_MAP); pairs && !r->bad; pairs--) {
        OdsValue key = ods_next(r);
        if (ods_is(key, "valid")) { list->valid = ods_whole(r) != 0; told_valid = 1; }
        else if (ods_is(key, "obstacles")) {
            uint32_t count = ods_count(r, ODS_LIST);
            told_obstacles = 1;
            for (list->obstacles = 0; list->obstacles < count && !r->bad; list->obstacles++)
                if (list->obstacles < room) ods_read_obstacle(r, &obstacles[list->obstacles]);
                else ods_skip(r);
        }
        else if (ods_is(key, "reasons")) ods_read_reasons(r, list);
        else if (ods_is(key, "seq")) list->seq = ods_whole(r);
        else if (ods_is(key, "ping_number")) list->ping_number = ods_whole(r);
        else if (ods_is(key, "t_ns")) list->t_ns = ods_whole(r);
        else if (ods_is(key, "utc_ns")) list->utc_ns = ods_whole(r);
        else if (ods_is(key, "made_ns")) list->made_ns = ods_whole(r);
        else if (ods_is(key, "made_utc_ns")) list->made_utc_ns = ods_whole(r);
        else if (ods_is(key, "left_out")) list->left_out = (uint64_t)ods_whole(r);
        else if (ods_is(key, "site")) ods_read_site(r, list);
        else if (ods_is(key, "pose")) ods_read_pose(r, list);
        else ods_skip(r);
    }
    return !r->bad && told_valid && told_obstacles;
}

#endif
