/* SPDX-License-Identifier: MIT */
/* The DensiStick's driver against a model of the chips behind its USB bridge. */
#include "instrument/dektronics-densistick/densistick.h"
#include "testing.h"

#include <string.h>

enum { EEPROM_SIZE = 1024, SENSOR = 0x39, LAMP = 0x2F };

typedef struct stick {
    transport base;
    uint8_t eeprom[EEPROM_SIZE];
    uint8_t registers[256];
    uint8_t pointer;
    uint8_t answer[64];
    size_t answer_size;
    uint8_t lamp_current, pins;
    double light; /* count at gain 1 */
    int samples;
    bool gone, silent;
    int64_t now;
} stick;

static void put_u32(uint8_t *b, uint32_t v)
{
    for (int i = 0; i < 4; i++)
        b[i] = (uint8_t)(v >> (24 - 8 * i));
}

static void put_float(uint8_t *b, float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    put_u32(b, bits);
}

static void fill_calibration(uint8_t *b)
{
    put_u32(b, 1);
    for (int i = 0; i < DENSISTICK_GAINS; i++)
        put_float(b + 16 + 4 * i, 0.5F * (float)(1 << i));
    put_u32(b + 60, densistick_checksum(b + 16, 11));
    put_float(b + 80, 0.08F);
    put_float(b + 84, 10.0F);
    put_float(b + 88, 1.5F);
    put_float(b + 92, 0.5F);
    put_u32(b + 108, densistick_checksum(b + 80, 7));
}

/* What the sensor would put into its FIFO now: light times gain, or saturation. */
static void take_sample(stick *s, uint8_t *out)
{
    const unsigned gain = s->registers[0xD4] & 0x0F;
    const double count = s->light * 0.5 * (double)(1 << gain);
    const uint32_t raw = count < 67108863.0 ? (uint32_t)count : 0;
    for (int i = 0; i < 4; i++)
        out[i] = (uint8_t)(raw >> (8 * i));
    out[4] = raw == 0 ? 0x20 : 0;
    out[5] = (uint8_t)gain;
    out[6] = 0;
    s->samples++;
}

static void answer_read(stick *s, uint8_t address, size_t n)
{
    s->answer[0] = (uint8_t)(0xD0 + (n - 1) / 4);
    s->answer[1] = (uint8_t)n;
    s->answer_size = 64;
    if ((address & 0xFC) == 0x50) {
        const size_t at = (size_t)(address & 3) << 8 | s->pointer;
        memcpy(s->answer + 2, s->eeprom + at, n);
    } else if (s->pointer == 0xFD) {
        const bool ready = (s->registers[0x80] & 3) == 3 && s->registers[0x83] == (719 & 0xFF);
        s->answer[2] = ready ? 1 : 0; /* 4 + 3 bytes */
        s->answer[3] = ready ? 3 : 0;
    } else if (s->pointer == 0xFF) {
        take_sample(s, s->answer + 2);
    } else {
        memcpy(s->answer + 2, s->registers + s->pointer, n);
    }
}

static cal_status stick_write(transport *t, const void *bytes, size_t n, int timeout_ms)
{
    stick *s = (stick *)t;
    const uint8_t *report = bytes;
    (void)timeout_ms;
    if (s->gone)
        return CAL_GONE;
    if (report[0] == 0xC2) {
        assert_int_equal(n, 5);
        answer_read(s, report[1], report[3]);
        return CAL_OK;
    }
    assert_int_equal(n, 4 + 4 * (size_t)(report[0] - 0xD0 + 1));
    if (report[1] == LAMP)
        s->lamp_current = report[4];
    else if (report[2] == 0x02)
        s->pointer = report[4];
    else if (report[1] == SENSOR)
        memcpy(s->registers + s->pointer, report + 4, report[3]);
    return CAL_OK;
}

static cal_status stick_read(transport *t, void *bytes, size_t capacity, size_t *got,
                             int timeout_ms)
{
    stick *s = (stick *)t;
    *got = 0;
    if (s->answer_size == 0 || s->silent) {
        s->now += timeout_ms;
        return CAL_TIMEOUT;
    }
    assert_true(capacity >= s->answer_size);
    memcpy(bytes, s->answer, s->answer_size);
    *got = s->answer_size;
    s->answer_size = 0;
    return CAL_OK;
}

static cal_status stick_set_feature(transport *t, const uint8_t *report, size_t n)
{
    stick *s = (stick *)t;
    if (s->gone)
        return CAL_GONE;
    if (report[0] == 0xB0) {
        assert_int_equal(n, 5);
        s->pins = report[3];
    }
    return CAL_OK;
}

static cal_status stick_get_feature(transport *t, uint8_t *report, size_t n)
{
    static const uint8_t version[] = {0x02, 0x60, 0x02, 0x00};
    assert_true(n >= 5 && report[0] == 0xA0);
    memcpy(report + 1, version, sizeof version);
    return ((stick *)t)->gone ? CAL_GONE : CAL_OK;
}

static int64_t stick_now(transport *t) { return ((stick *)t)->now; }
static void stick_close(transport *t) { ((stick *)t)->gone = true; }

static const transport_ops stick_ops = {
    .scheme = "hid",
    .messages = true,
    .write = stick_write,
    .read = stick_read,
    .set_feature = stick_set_feature,
    .get_feature = stick_get_feature,
    .now_ms = stick_now,
    .close = stick_close,
};

static void plug_in(stick *s)
{
    memset(s, 0, sizeof *s);
    s->base.ops = &stick_ops;
    s->base.vendor = 0x16D0;
    s->base.product = 0x1382;
    memcpy(s->eeprom + 0x100, "DPD\1\2\1\0", 7);
    fill_calibration(s->eeprom + 0x110);
    s->registers[0x90] = 6;
    s->registers[0x91] = 0x11;
    s->registers[0x92] = 0x5C;
}

/* Light that a patch of this density reflects, by the calibration above. */
static double light_of(double density)
{
    const double basic = pow(10.0, (density - 0.08) / (1.5 - 0.08) * log10(0.05) + 1.0);
    return basic * 16.0 * 200.0 * 720.0 * 1.388889e-3;
}

static void checksum_is_the_makers(void **state)
{
    (void)state;
    const uint8_t words[] = {1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0};
    assert_int_equal(densistick_checksum(words, 3), 0x64C51784);
}

static void density_comes_out_as_the_patch_has_it(void **state)
{
    (void)state;
    static const double densities[] = {0.08, 0.5, 1.0, 1.44, 1.5, 2.0};
    for (size_t i = 0; i < sizeof densities / sizeof densities[0]; i++) {
        stick s;
        instrument in;
        cal_error err;
        reading r;
        plug_in(&s);
        s.light = light_of(densities[i]);
        assert_int_equal(instrument_open("auto", &s.base, 1000, &in, &err), CAL_OK);
        assert_string_equal(instrument_fact_get(&in, "model"), "DensiStick");
        assert_string_equal(instrument_fact_get(&in, "sensor"), "TSL2585");
        assert_int_equal(in.driver->measure(&in, 1000, &r, &err), CAL_OK);
        check_near(r.value, densities[i], 1e-4, "density");
        assert_int_equal(r.kind, READING_REFLECTION);
        assert_int_equal(s.registers[0xDC], 0x04);
        assert_int_equal(s.registers[0xDD], 0x04);
        assert_int_equal(s.registers[0x40], 0x02);
        assert_int_equal(s.registers[0x80], 0); /* sensor off and lamp idle afterwards */
        assert_int_equal(s.lamp_current, 127);
        instrument_close(&in);
    }
}

static void bright_patch_is_read_at_a_lower_gain(void **state)
{
    (void)state;
    stick s;
    instrument in;
    cal_error err;
    reading r;
    plug_in(&s);
    s.light = 3e6;
    assert_int_equal(instrument_open("densistick", &s.base, 1000, &in, &err), CAL_OK);
    assert_int_equal(in.driver->measure(&in, 1000, &r, &err), CAL_OK);
    assert_int_equal(s.registers[0xD4] & 0x0F, 5);
    s.light = 1e9;
    assert_int_equal(in.driver->measure(&in, 1000, &r, &err), CAL_MISREAD);
    assert_int_equal(s.lamp_current, 127);
    s.light = 0.0;
    assert_int_equal(in.driver->measure(&in, 1000, &r, &err), CAL_MISREAD);
    instrument_close(&in);
}

static void damaged_calibration_is_never_used(void **state)
{
    (void)state;
    densistick_calibration c;
    uint8_t good[DENSISTICK_CALIBRATION] = {0};
    fill_calibration(good);
    assert_true(densistick_calibration_parse(good, &c));
    check_near(c.gain[9], 256.0, 0.0, "gain");
    for (size_t i = 0; i < sizeof good; i++) {
        const bool unused = (i >= 4 && i < 16) || (i >= 64 && i < 80);
        for (int bit = 0; bit < 8 && !unused; bit++) {
            uint8_t bad[DENSISTICK_CALIBRATION];
            memcpy(bad, good, sizeof bad);
            bad[i] ^= (uint8_t)(1 << bit);
            assert_false(densistick_calibration_parse(bad, &c));
        }
    }
    stick s;
    instrument in;
    cal_error err;
    plug_in(&s);
    s.eeprom[0x110 + 84] ^= 1;
    assert_int_equal(instrument_open("densistick", &s.base, 1000, &in, &err), CAL_CALIBRATE);
    instrument_close(&in);
}

static void what_is_no_densistick_is_refused(void **state)
{
    (void)state;
    stick s;
    instrument in;
    cal_error err;
    plug_in(&s);
    s.eeprom[0x101] = 'X';
    assert_int_equal(instrument_open("densistick", &s.base, 1000, &in, &err), CAL_PROTOCOL);
    plug_in(&s);
    s.registers[0x92] = 0;
    assert_int_equal(instrument_open("densistick", &s.base, 1000, &in, &err), CAL_PROTOCOL);
    plug_in(&s);
    s.silent = true;
    assert_int_equal(instrument_open("densistick", &s.base, 1000, &in, &err), CAL_TIMEOUT);
    plug_in(&s);
    s.gone = true;
    assert_int_equal(instrument_open("densistick", &s.base, 1000, &in, &err), CAL_GONE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(checksum_is_the_makers),
        cmocka_unit_test(density_comes_out_as_the_patch_has_it),
        cmocka_unit_test(bright_patch_is_read_at_a_lower_gain),
        cmocka_unit_test(damaged_calibration_is_never_used),
        cmocka_unit_test(what_is_no_densistick_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
