/* What an image adds to what speaks for and against the existence of each live object (doubt.py). */

#include "ods/tracker/association/front.h"
#include "ods/tracker/association/onset.h"
#include "ods/tracker/association/strength.h"
#include "ods/tracker/track/doubt.h"
#include "ods/tracker/track/existence.h"

/* What is taken to be known of the echoes of spots: see `Spots` of doubt.py. */
typedef struct {
    double sharp, front, crowd;
} Spots;

/* `LAWS` of doubt.py, */
typedef struct {
    const OnsetLaw *onset;
    const FrontLaw *front;
    const StrengthLaw *strength;
    const Seen *seen;
} Laws;

/* in a signature: four arguments. */
#define LAWS "f8[7] onset, f8[6] front, f8[3] strength, f8[5] seen"

/* Returns the laws of the four arguments from number k on. */
static Laws laws_from(const Argument *arguments, int k)
{
    return (Laws){ARRAY(const OnsetLaw, k), ARRAY(const FrontLaw, k + 1), ARRAY(const StrengthLaw, k + 2),
                  ARRAY(const Seen, k + 3)};
}

static Chain chain_of(const Doubt *d, int64_t i)
{
    return (Chain){d->visible[i], d->silent[i], d->nothing[i], d->spot[i]};
}

static void keep(const Doubt *d, int64_t i, Chain chain)
{
    d->visible[i] = chain.visible, d->silent[i] = chain.silent, d->nothing[i] = chain.nothing, d->spot[i] = chain.spot;
}

/* Takes a log-likelihood ratio in, in place of the one `taken` before. Against a confirmed object it says nothing. */
static Chain by_new_ratio(Chain chain, double ratio, double *taken, bool confirmed)
{
    const double change = ratio - *taken;
    if (confirmed && change < 0.0)
        return chain;
    *taken = ratio;
    return told_apart(chain, 0.0, change);
}

/* Judges by how sharply the echoes set in. */
static Chain by_onset(const Doubt *d, int64_t i, Chain chain, double of_echo, double of_spots, bool confirmed,
                      const OnsetLaw *law)
{
    if (!(of_echo > 0.0))
        return chain;
    d->sharp[i] += of_echo < law->sharp;
    d->set_in[i] += 1.0;
    return by_new_ratio(chain, evidence_of_onset(d->sharp[i], d->set_in[i], of_spots, law), &d->by_onset[i], confirmed);
}

/* Judges by how the last echoes set in. */
static Chain by_front(const Doubt *d, int64_t i, Chain chain, double of_echo, double of_spots, bool confirmed,
                      const FrontLaw *law)
{
    if (!(of_echo > 0.0))
        return chain;
    d->fronts[i] = FRONT_FADE * d->fronts[i] + log_odds_of_front(of_echo, law);
    d->judged[i] = FRONT_FADE * d->judged[i] + 1.0;
    return by_new_ratio(chain, evidence_of_front(d->fronts[i], d->judged[i], of_spots, law), &d->by_front[i],
                        confirmed);
}

/* Judges by how strong the echoes are; k: the object's place in `typical`. */
static Chain by_strength(const Doubt *d, int64_t i, Chain chain, double echo_db, const Typical *typical, int64_t k,
                         const StrengthLaw *law)
{
    if (!(echo_db > 0.0))
        return chain;
    d->strength[i] += (echo_db - typical->mean_db[k]) / typical->sigma_db[k];
    d->told[i] += 1.0;
    const double excess = d->strength[i] / d->told[i];
    const double ratio = evidence_of_strength(excess, d->told[i], typical->sigma_db[k], typical->known[k], law);
    const double change = ratio - d->by_strength[i];
    d->by_strength[i] = ratio;
    return told_apart(chain, change, change);
}

static double logit(double share)
{
    return log(share / (1.0 - share));
}

/* Judges by the share of spots, if that is another than before. */
static Chain by_share(const Doubt *d, int64_t i, Chain chain, double spots)
{
    if (spots == d->spots[i])
        return chain;
    const double change = logit(d->spots[i]) - logit(spots);
    d->spots[i] = spots;
    return told_apart(chain, 0.0, change);
}

/* Sets objects from `first` on, one an unexplained echo, given births a scan: see `Unexplained` of doubt.py. */
KERNEL(doubt_begin,
       "out f8[17,n] doubt, int first, float births, f8[k] clutter, f8[k] strength, f8[k] onset, f8[k] front, "
       "float spots, f8[3,k] typical, float spots_sharp, float spots_front, " LAWS)
{
    const int64_t first = INT(1), count = SIZE(3, 0);
    const Doubt d = doubt_rows(ARRAY(double, 0), SIZE(0, 1));
    const double births = FLOAT(2), *clutter = ARRAY(const double, 3), *strength = ARRAY(const double, 4);
    const double *onset = ARRAY(const double, 5), *front = ARRAY(const double, 6), spots = FLOAT(7);
    const Typical typical = typical_rows(ARRAY(double, 8), count);
    const Laws laws = laws_from(arguments, 11);
    for (int64_t k = 0; k < count && first + k < SIZE(0, 1); k++) {
        const int64_t i = first + k;
        const double none = clutter[k] / (births + clutter[k]);
        Chain chain = {1.0 - none, 0.0, (1.0 - spots) * none, spots * none};
        d.spots[i] = spots;
        chain = by_strength(&d, i, chain, strength[k], &typical, k, laws.strength);
        chain = by_front(&d, i, chain, front[k], FLOAT(10), false, laws.front);
        keep(&d, i, by_onset(&d, i, chain, onset[k], FLOAT(9), false, laws.onset));
        d.first_visible[i] = d.visible[i];
    }
}

/* What is the same for all objects of an image, `dt` s after the one before. */
typedef struct {
    double dt;
    Rates rates;
    double detection_probability, share;
    Spots spots;
    Laws laws;
} Assumed;

/* What is seen of one object, beside its look: echoes so far, of which this image may be one. */
typedef struct {
    int64_t echoes;
    bool confirmed, hit;
} OfObject;

static void judge_one(const Doubt *d, int64_t i, const Look *look, const Typical *typical, OfObject of,
                      const Assumed *known)
{
    const Laws *laws = &known->laws;
    const Spots spots = known->spots;
    const double watched = look->watched[i];
    Chain chain = by_onset(d, i, chain_of(d, i), look->onset[i], spots.sharp, of.confirmed, laws->onset);
    chain = by_front(d, i, chain, look->front[i], spots.front, of.confirmed, laws->front);
    chain = carried_on(chain, of.echoes, watched, known->dt, known->rates);
    const Often often = how_often(d->hits[i], d->looks[i], known->detection_probability, spots.crowd, laws->seen);
    chain = after_image(chain, of.hit, look->llr[i], look->expected[i], often);
    chain = by_strength(d, i, chain, look->strength[i], typical, i, laws->strength);
    /* confirmed objects are judged by what is known of spots by now */
    keep(d, i, of.confirmed ? by_share(d, i, chain, known->share) : chain);
    d->hits[i] += of.hit;
    d->looks[i] += of.hit ? 1.0 : watched;
}

/* Judges by an image, `dt` seconds after the one before: see `doubt.take_image`. */
KERNEL(doubt_take_image,
       "out f8[17,n] doubt, i8[n] echoes, b1[n] confirmed, b1[n] hit, f8[6,n] look, float spots, f8[3,n] typical, "
       "float dt, float silence, float recovery, float loss, float detection_probability, float sharp, "
       "float of_fronts, float crowd, " LAWS)
{
    const int64_t n = SIZE(0, 1), *echoes = ARRAY(const int64_t, 1);
    const Doubt d = doubt_rows(ARRAY(double, 0), n);
    const bool *confirmed = ARRAY(const bool, 2), *hit = ARRAY(const bool, 3);
    const Look look = look_rows(ARRAY(double, 4), n);
    const Typical typical = typical_rows(ARRAY(double, 6), n);
    const Assumed known = {FLOAT(7), {FLOAT(8), FLOAT(9), FLOAT(10)}, FLOAT(11),
                           FLOAT(5), {FLOAT(12), FLOAT(13), FLOAT(14)}, laws_from(arguments, 15)};
    for (int64_t i = 0; i < n; i++) {
        const OfObject of = {echoes[i], confirmed[i], hit[i]};
        judge_one(&d, i, &look, &typical, of, &known);
    }
}

KERNEL_FLOAT(doubt_proof, "f8[17,n] doubt, int i, float dearer")
{
    const Doubt d = doubt_rows(ARRAY(double, 0), SIZE(0, 1));
    return INT(1) >= 0 && INT(1) < SIZE(0, 1) ? proof_of(&d, INT(1), FLOAT(2)) : NAN;
}

/* Fills in the probability that an object, if it exists, gives echoes; `returned`: that a silent one does. */
KERNEL(doubt_visibilities, "f8[17,n] doubt, float returned, out f8[n] visibility")
{
    const int64_t n = SIZE(0, 1);
    const Doubt d = doubt_rows(ARRAY(double, 0), n);
    double *found = ARRAY(double, 2);
    for (int64_t i = 0; i < n; i++)
        found[i] = (d.visible[i] + d.silent[i] * FLOAT(1)) / larger(SMALLEST, d.visible[i] + d.silent[i]);
}

/* Fills in what the `ended` tell as no objects: (2, n) probabilities of a spot, and of none; 0 for the others. And what
   the echoes of spots were like: the fields of `Counted`. */
KERNEL(doubt_as_nothing, "f8[17,n] doubt, b1[n] ended, out f8[2,n] chances, out f8[4] counted")
{
    const int64_t n = SIZE(0, 1);
    const Doubt d = doubt_rows(ARRAY(double, 0), n);
    const bool *ended = ARRAY(const bool, 1);
    double *spot = ARRAY(double, 2), *none = spot + n, *counted = ARRAY(double, 3);
    const double *told[] = {d.sharp, d.set_in, d.fronts, d.judged};
    memset(counted, 0, 4 * sizeof *counted);
    for (int64_t i = 0; i < n; i++) {
        spot[i] = ended[i] ? d.spot[i] : 0.0;
        none[i] = ended[i] ? d.spot[i] + d.nothing[i] : 0.0;
        for (int64_t k = 0; ended[i] && k < 4; k++)
            counted[k] += d.spot[i] * told[k][i];
    }
}
