/* The chain of one object, asked by Python (existence.h). */

#include "ods/tracker/track/existence.h"

/* Chain, rates and so on in a signature, each number an argument. */
#define CHAIN "float visible, float silent, float nothing, float spot"
#define CHAIN_FROM(k) ((Chain){FLOAT(k), FLOAT((k) + 1), FLOAT((k) + 2), FLOAT((k) + 3)})

static void put(double *out, Chain chain)
{
    out[0] = chain.visible, out[1] = chain.silent, out[2] = chain.nothing, out[3] = chain.spot;
}

KERNEL(existence_carried_on,
       CHAIN ", int echoes, float watched, float dt, float silence, float recovery, float loss, out f8[4] chain")
{
    put(ARRAY(double, 10),
        carried_on(CHAIN_FROM(0), INT(4), FLOAT(5), FLOAT(6), (Rates){FLOAT(7), FLOAT(8), FLOAT(9)}));
}

KERNEL(existence_how_often,
       "float hits, float looks, float detection_probability, float crowd, f8[5] seen, out f8[2] often")
{
    const Often often = how_often(FLOAT(0), FLOAT(1), FLOAT(2), FLOAT(3), ARRAY(const Seen, 4));
    double *out = ARRAY(double, 5);
    out[0] = often.body, out[1] = often.spot;
}

KERNEL(existence_after_image,
       CHAIN ", bool hit, float llr, float expected, float often_body, float often_spot, out f8[4] chain")
{
    put(ARRAY(double, 9), after_image(CHAIN_FROM(0), BOOL(4), FLOAT(5), FLOAT(6), (Often){FLOAT(7), FLOAT(8)}));
}

KERNEL(existence_told_apart, CHAIN ", float from_nothing, float from_spot, out f8[4] chain")
{
    put(ARRAY(double, 6), told_apart(CHAIN_FROM(0), FLOAT(4), FLOAT(5)));
}
