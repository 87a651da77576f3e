/** Bytes of a torn quad's corner: x, row (2 x i16, from the strip's x0 and the panorama's row 0), w (f32), RGBA (4 x u8). */
export const TORN_VERTEX_BYTES = 12;
