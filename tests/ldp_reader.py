#!/usr/bin/env python3
"""An independent reader of .ldp files, written from core/panorama/file/FORMAT.md alone (Python 3.8, Pillow; slow on purpose).

    ldp_reader.py FILE.ldp            prints the header and, for every layer, CRC-32C of its planes
    ldp_reader.py FILE.ldp -o DIR     also writes DIR/layer_N_{disparity,coverage,alpha,colour[,even]}.png

The planes' bytes, row by row, of which the checksums are: disparity u16 little-endian (65535 where absent), coverage u8,
alpha u8 (255 where a layer has none and is present), colour r g b; of local exposure also even, the colours evened.
"""
import io
import struct
import sys

from PIL import Image

CRC_TABLE = []
for b in range(256):
    for _ in range(8):
        b = b >> 1 ^ (0x82F63B78 if b & 1 else 0)
    CRC_TABLE.append(b)


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ CRC_TABLE[(crc ^ byte) & 255]
    return crc ^ 0xFFFFFFFF


def need(condition, what):
    if not condition:
        raise ValueError(what)


# ---- sections 1 to 4


def read_chunks(file):
    need(file[:8] == b"\xabLDP\r\n\x1a\n", "magic")
    version, count, length, table_crc, header_crc = struct.unpack_from("<IIQII", file, 8)
    need(header_crc == crc32c(file[:28]), "header checksum")
    need(version in (1, 2), "version")
    need(length == len(file) and 32 + 32 * count <= length, "length")
    need(table_crc == crc32c(file[32:32 + 32 * count]), "table checksum")
    chunks, end = {}, 32 + 32 * count
    for i in range(count):
        kind, layer, strip, offset, size, crc, reserved = struct.unpack_from("<4sHHQQII", file, 32 + 32 * i)
        need(offset == end and size <= length - offset and reserved == 0, "table entry")
        end += size
        data = file[offset:end]
        need(crc32c(data) == crc, "checksum of " + kind.decode())
        need((kind, layer, strip) not in chunks, "chunk twice")
        need(kind in (b"HEAD", b"LAYR", b"DPTH", b"ALPH", b"COLR") or kind[:1].islower(), "unknown needed chunk")
        chunks[kind, layer, strip] = data
        if kind == b"COLR" and version == 1:
            need(data[0] <= 2, "codec of version 2 in a file of version 1")
    need(end == length, "end of the last chunk")
    return chunks


def read_head(data):
    width, height, layers, rays, flags, zero = struct.unpack_from("<IIBBBB", data)
    need(1 <= width <= 65535 and 1 <= height <= 16368 and width * height <= 1 << 28, "size")
    need(1 <= layers <= 8 and rays <= 1 and flags <= 3 and zero == 0 and len(data) == 204, "HEAD")
    names = ("centre", 3), ("axes", 9), ("radius", 1), ("theta_begin", 1), ("theta_end", 1), ("theta_left", 1), \
        ("theta_pitch", 1), ("v_top", 1), ("v_pitch", 1), ("w_far", 1), ("w_near", 1), ("limits", 3)
    head = dict(width=width, height=height, layers=layers, rays=("pushbroom", "central")[rays], wraps=flags & 1)
    at = 12
    for name, n in names:
        values = struct.unpack_from("<%dd" % n, data, at)
        head[name] = values[0] if n == 1 else values
        at += 8 * n
    return head


# ---- section 5


class RangeDecoder:
    def __init__(self, data):
        self.data, self.at, self.range, self.code = data, 4, 0xFFFFFFFF, int.from_bytes(data[:4], "big")

    def bit(self, models, key):
        zero, seen = models.get(key, (32768, 0))
        bound = (self.range >> 16) * zero
        rate = 655360 // (10 * seen + 16)
        if self.code < bound:
            bit, self.range = 0, bound
            zero += ((65535 - zero) * rate) >> 16
        else:
            bit, self.code, self.range = 1, self.code - bound, self.range - bound
            zero -= (zero * rate) >> 16
        models[key] = zero, min(seen + 1, 63)
        while self.range < 1 << 24:
            need(self.at < len(self.data), "coded data ends too early")
            self.range, self.code = self.range << 8, (self.code << 8 | self.data[self.at]) & 0xFFFFFFFF
            self.at += 1
        return bit


def clamp(v, low, high):
    return max(low, min(high, v))


def read_coverage(rc, width, height):
    tiles, T, P = {}, {}, {}
    for ty in range((height + 15) // 16):
        for tx in range((width + 15) // 16):
            w, n, nw, ne = (tiles.get((tx + dx, ty + dy), 0) for dx, dy in ((-1, 0), (0, -1), (-1, -1), (1, -1)))
            k = 27 * w + 9 * n + 3 * nw + ne
            tiles[tx, ty] = 0 if rc.bit(T, (k, 0)) == 0 else 1 + rc.bit(T, (k, 1))
    around = (-1, -2), (0, -2), (1, -2), (-2, -1), (-1, -1), (0, -1), (1, -1), (2, -1), (-2, 0), (-1, 0)
    present = {}
    for y in range(height):
        for x in range(width):
            state = tiles[x // 16, y // 16]
            if state == 2:
                context = 0
                for dx, dy in around:
                    context = 2 * context + present.get((x + dx, y + dy), 0)
                state = rc.bit(P, context)
            present[x, y] = state
    return tiles, present


def read_number(rc, models, which, e0):
    k = 0
    while k < 8 and rc.bit(models, (which, "U", k)):
        k += 1
    m = 1
    for i in range(k - 1, -1, -1):
        m = 2 * m + rc.bit(models, (which, "V", k, i == k - 1))
    m -= 1
    return e0 + ((m + 1) // 2 if m % 2 else -(m // 2))


def expected(values, x, y):
    w, n, nw = values.get((x - 1, y)), values.get((x, y - 1)), values.get((x - 1, y - 1))
    if w is None or n is None:
        return (n or 0) if w is None else w
    return (w + n) // 2 if nw is None else clamp(w + n - nw, min(w, n), max(w, n))


def read_ranges(rc, present, width, height, block):
    used = {(x // block, y // block) for (x, y), p in present.items() if p}
    lows, spans, models = {}, {}, {}
    for by in range((height + block - 1) // block):
        for bx in range((width + block - 1) // block):
            if (bx, by) not in used:
                continue
            low = read_number(rc, models, 0, expected(lows, bx, by))
            e = expected(spans, bx, by)
            span = read_number(rc, models, 1 if e <= 2 else 2 if e <= 10 else 3, e)
            need(0 <= low and 0 <= span and low + span <= 255, "block range")
            lows[bx, by], spans[bx, by] = low, span
    return {b: (lows[b], lows[b] + spans[b]) for b in lows}


def g(d):
    level = (0, 1, 2, 2)[abs(d)] if abs(d) < 4 else 3
    return 3 + (level if d > 0 else -level)


def read_code(rc, M, w, n, nw, ne, ww, nn):
    absent = (w is None) + (n is None)
    if absent == 2:
        w = n = ne if ne is not None else nw if nw is not None else 0
    n = w if n is None else n
    w = (nw if nw is not None else n) if w is None else w
    nw, ne = n if nw is None else nw, n if ne is None else ne
    ww, nn = w if ww is None else ww, n if nn is None else nn
    q = 49 * g(n - nw) + 7 * g(w - nw) + g(ne - n)
    first = clamp(w + n - nw, min(w, n), max(w, n))
    if not rc.bit(M, ("A", q, 3 + absent if absent else (ww == w) + 2 * (nn == n))):
        return first
    tried = {first}
    second = n if first == w else w
    if second not in tried:
        if not rc.bit(M, ("B", q, (w == first) + 2 * (n == first))):
            return second
        tried.add(second)
    third = nw if ne in (first, second) else ne
    if third not in tried:
        if not rc.bit(M, ("C", q)):
            return third
        tried.add(third)
    above = [c for c in range(first + 1, 16) if c not in tried]
    below = [c for c in range(first - 1, -1, -1) if c not in tried]
    up = rc.bit(M, ("D", 7 * g(n - nw) + g(w - nw))) if above and below else bool(above)
    way = above if up else below
    a = min(2, max(abs(n - nw), abs(w - nw), abs(ne - n)))
    for i, code in enumerate(way[:-1]):
        if not rc.bit(M, ("F", 2 * a + bool(up), i)):
            return code
    return way[-1]


def read_disparity(rc, present, ranges, width, height, block):
    disparity, codes, M = {}, {}, {}

    def range_at(x, y):
        return ranges[x // block, y // block] if block else ranges

    for y in range(height):
        for x in range(width):
            if not present[x, y]:
                continue
            low, high = range_at(x, y)
            code = 0
            if low < high:
                near = []
                for px, py in ((x - 1, y), (x, y - 1), (x - 1, y - 1), (x + 1, y - 1), (x - 2, y), (x, y - 2)):
                    if (px, py) not in codes:
                        near.append(None)
                    elif range_at(px, py) == (low, high):
                        near.append(codes[px, py])
                    else:
                        near.append(clamp((disparity[px, py] - 15 * low + (high - low) // 2) // (high - low), 0, 15))
                code = read_code(rc, M, *near)
            codes[x, y] = code
            disparity[x, y] = 15 * low + (high - low) * code
    return disparity


# ---- sections 6 and 7


def read_alpha(data, present, width, height):
    rc, models, alpha = RangeDecoder(data), {}, {}
    for y in range(height):
        for x in range(width):
            if not present[x, y]:
                continue
            w, n = alpha.get((x - 1, y)), alpha.get((x, y - 1))
            kinds = [0 if v is None else 1 if v == 0 else 3 if v == 255 else 2 for v in (w, n)]
            k = 4 * kinds[0] + kinds[1]
            value = 255
            if rc.bit(models, ("O", k)):
                value = 0
                if rc.bit(models, ("Z", k)):
                    known = [v for v in (w, n) if v is not None]
                    e = sum(known) // len(known) if known else 128
                    node = 1
                    for _ in range(8):
                        node = 2 * node + rc.bit(models, ("M", e >> 6, node))
                    value = node & 255
            alpha[x, y] = value
    need(rc.at == len(data), "opacity is not used up")
    return alpha


def curve_point(i):
    x = y = 0
    for s in (1, 2, 4, 8):
        rx = i // 2 & 1
        ry = (i ^ rx) & 1
        if ry == 0:
            x, y = (s - 1 - y, s - 1 - x) if rx else (y, x)
        x, y, i = x + s * rx, y + s * ry, i // 4
    return x, y


def guide_of(pixels, width, height):
    """What gives the colour of a pixel of a lossy WebP, guided by luma: section 7."""
    across, down = width // 2, height // 2

    def towards_zero(a, b):
        return a // b if a >= 0 else -(-a // b)

    def inside(i, j):
        return min(max(i, 0), across - 1), min(max(j, 0), down - 1)

    def luma(x, y):
        r, g, b = pixels[x, y]
        return (77 * r + 150 * g + 29 * b + 128) >> 8

    def sums(i, j):
        four = [(2 * i + x, 2 * j + y) for y in (0, 1) for x in (0, 1)]
        return [sum(luma(*p) for p in four)] + [sum(pixels[p][c] - luma(*p) for p in four) for c in (0, 2)]

    blocks = {(i, j): sums(i, j) for j in range(down) for i in range(across)}

    def slope(i, j, c):
        nine = [blocks[inside(i + x, j + y)] for y in (-1, 0, 1) for x in (-1, 0, 1)]
        y, yy = sum(b[0] for b in nine), sum(b[0] * b[0] for b in nine)
        d, yd = sum(b[c] for b in nine), sum(b[0] * b[c] for b in nine)
        return min(max(towards_zero(5 * (9 * yd - y * d), (9 * yy - y * y + 16384) // 64), -512), 512)

    of_blocks = {ij: (blocks[ij][0], slope(*ij, 1), slope(*ij, 2)) for ij in blocks}

    def guided(x, y):
        i, j = x // 2, y // 2
        i2, j2 = i + (1 if x % 2 else -1), j + (1 if y % 2 else -1)
        corners = ((9, i, j), (3, i2, j), (3, i, j2), (1, i2, j2))
        around, red, blue = (sum(w * of_blocks[inside(a, b)][k] for w, a, b in corners) for k in range(3))
        slopes = red, -towards_zero(77 * red + 29 * blue, 150), blue
        rise = 64 * luma(x, y) - around
        return tuple(min(max(v + (s * rise + (1 << 17) >> 18), 0), 255) for v, s in zip(pixels[x, y], slopes))

    return guided


def read_colour(data, tiles, present, width, height):
    codec = data[0]
    stored = [(tx, ty) for ty in range((height + 15) // 16) for tx in range((width + 15) // 16) if tiles[tx, ty]]
    need((codec == 0) == (not stored) and codec <= 4, "codec")
    if not stored:
        return {}
    curve = [curve_point(i) for i in range(256)]
    inside = {(tx, ty): [(16 * tx + x, 16 * ty + y) for x, y in curve if present.get((16 * tx + x, 16 * ty + y))]
              for tx, ty in stored}
    whole = [tile for tile in stored if codec <= 2 or len(inside[tile]) >= 192]
    gathered = [xy for tile in stored if tile not in whole for xy in inside[tile]]
    per_row = (width + 15) // 16
    count = len(whole) + (len(gathered) + 255) // 256
    image = Image.open(io.BytesIO(data[1:]))
    need(image.format == ("WEBP", "JPEG")[codec % 2], "kind of image")
    need(image.size == (16 * per_row, 16 * ((count + per_row - 1) // per_row)), "size of the packed image")
    pixels = image.convert("RGB").load()
    guide = guide_of(pixels, *image.size) if data[13:17] == b"VP8 " else lambda x, y: pixels[x, y]

    def colour(tile, x, y):
        return guide(tile % per_row * 16 + x, tile // per_row * 16 + y)

    colours = {xy: colour(k, xy[0] % 16, xy[1] % 16) for k, tile in enumerate(whole) for xy in inside[tile]}
    for i, xy in enumerate(gathered):
        colours[xy] = colour(len(whole) + i // 256, *curve[i % 256])
    return colours


def read_layer(chunks, head, layer):
    block, strip_px, count, low, high, has_alpha, zero = struct.unpack("<IIQBBBB", chunks[b"LAYR", layer, 65535])
    width, height = head["width"], head["height"]
    planes = dict(disparity={}, coverage={}, alpha={}, colour={})
    for s in range((width + strip_px - 1) // strip_px):
        x0 = s * strip_px
        w = min(width, x0 + strip_px) - x0
        rc = RangeDecoder(chunks[b"DPTH", layer, s])
        tiles, present = read_coverage(rc, w, height)
        ranges = read_ranges(rc, present, w, height, block) if block else (low, high)
        parts = dict(coverage=present, disparity=read_disparity(rc, present, ranges, w, height, block))
        need(rc.at == len(rc.data), "coded data is not used up")
        parts["alpha"] = read_alpha(chunks[b"ALPH", layer, s], present, w, height) if has_alpha else \
            {xy: 255 for xy, p in present.items() if p}
        parts["colour"] = read_colour(chunks[b"COLR", layer, s], tiles, present, w, height)
        for name, part in parts.items():
            planes[name].update({(x0 + x, y): v for (x, y), v in part.items()})
    need(sum(planes["coverage"].values()) == count, "number of present pixels")
    order = [(x, y) for y in range(height) for x in range(width)]
    return dict(disparity=b"".join(struct.pack("<H", planes["disparity"].get(xy, 65535)) for xy in order),
                coverage=bytes(planes["coverage"][xy] for xy in order),
                alpha=bytes(planes["alpha"].get(xy, 0) for xy in order),
                colour=b"".join(bytes(planes["colour"].get(xy, (0, 0, 0))) for xy in order))


def read_exposure(data):
    """The response's light at levels 0, 16 .. 256; columns, rows and factors (1/4096) of the nodes."""
    light = (0,) + struct.unpack_from("<16I", data)
    need(all(a < b for a, b in zip(light, light[1:])), "response")
    columns, rows = struct.unpack_from("<II", data, 64)
    need(1 <= columns <= 256 and 1 <= rows <= 256 and len(data) == 72 + 6 * columns * rows, "expo")
    factors = struct.unpack_from("<%dH" % (3 * columns * rows), data, 72)
    need(min(factors) > 0, "factor of the exposure")
    return light, columns, rows, factors


def factor_at(exposure, head, x, y, channel):
    _, columns, rows, factors = exposure

    def between(place, size, nodes, wraps):
        at = place / size * nodes - 0.5
        first = int(at // 1)
        pair = [n % nodes if wraps else clamp(n, 0, nodes - 1) for n in (first, first + 1)]
        return pair, at - first

    (i0, i1), s = between(x + 0.5, head["width"], columns, head["wraps"])
    (j0, j1), t = between(y + 0.5, head["height"], rows, False)
    left, right = ([factors[3 * (j * columns + i) + channel] for j in (j0, j1)] for i in (i0, i1))
    upper, lower = (a + s * (b - a) for a, b in zip(left, right))
    return (upper + t * (lower - upper)) / 4096


def even_level(light, c, factor, v):
    knot = c // 16
    of = (light[knot] + (c / 16 - knot) * (light[knot + 1] - light[knot])) * (1 / factor)
    e = 255
    if of < light[16]:
        knot = max(k for k in range(16) if light[k] <= of)
        e = min(255, 16 * (knot + (of - light[knot]) / (light[knot + 1] - light[knot])))
    t = max(0, v - 224) / 31
    return e + t * t * (c - e) if factor > 1 else e


def evened(colour, exposure, head):
    """A layer's colours, r g b row by row, at even exposure."""
    result = bytearray(colour)
    for i in range(0, len(colour), 3):
        x, y = i // 3 % head["width"], i // 3 // head["width"]
        for c in range(3):
            factor = factor_at(exposure, head, x, y, c)
            result[i + c] = int(even_level(exposure[0], colour[i + c], factor, max(colour[i:i + 3])) + 0.5)
    return bytes(result)


REASONS = ("blurred dark little_overlap no_parallax moved_forward moved_straight poses_doubtful photos_left_out "
           "exposure_jumps contradicted holes lens_doubtful looked_inward").split()


def read_quality(data):
    """The figures of a qual chunk by name."""
    count, = struct.unpack_from("<I", data)
    at, figures = 4, {}
    for _ in range(count):
        length, = struct.unpack_from("<H", data, at)
        name = data[at + 2:at + 2 + length].decode()
        need(not figures or name > max(figures), "order of keys")
        figures[name], = struct.unpack_from("<d", data, at + 2 + length)
        at += 10 + length
    need(at == len(data) and count <= 4096, "qual")
    return figures


def verdict_of(figures):
    """One line, or none where the sweep was not judged."""
    if figures.get("verdict") not in (0, 1, 2):
        return None
    line = ("good", "fair", "sweep_again")[int(figures["verdict"])] + " %.2f dB" % figures["expected_view_psnr_db"]
    for i in range(100):
        code = figures.get("reason.%02d.code" % i)
        if code is None:
            break
        line += " %s %.2f..%.2f" % (REASONS[int(code)], figures["reason.%02d.from_deg" % i], figures["reason.%02d.to_deg" % i])
    return line


def main():
    with open(sys.argv[1], "rb") as file:
        chunks = read_chunks(file.read())
    head = read_head(chunks[b"HEAD", 65535, 65535])
    print(" ".join("%s=%s" % item for item in head.items()))
    verdict = verdict_of(read_quality(chunks[b"qual", 65535, 65535])) if (b"qual", 65535, 65535) in chunks else None
    if verdict:
        print("verdict " + verdict)
    exposure = read_exposure(chunks[b"expo", 65535, 65535]) if (b"expo", 65535, 65535) in chunks else None
    for layer in range(head["layers"]):
        planes = read_layer(chunks, head, layer)
        if exposure:
            planes["even"] = evened(planes["colour"], exposure, head)
        for name, data in planes.items():
            print("layer %d %s %08x" % (layer + 1, name, crc32c(data)))
            if len(sys.argv) == 4 and sys.argv[2] == "-o":
                mode = dict(disparity="I;16", coverage="L", alpha="L", colour="RGB", even="RGB")[name]
                image = Image.frombytes(mode, (head["width"], head["height"]), data)
                image.save("%s/layer_%d_%s.png" % (sys.argv[3], layer + 1, name))


if __name__ == "__main__":
    main()
