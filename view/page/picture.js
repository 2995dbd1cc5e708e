// A picture as the server sends it (view/src/picture.rs): a header and a word of RGB9E5 per pixel.

const HEADER = 48;
// The unit of each exponent of RGB9E5.
export const SCALES = Float64Array.from({ length: 32 }, (_, e) => 2 ** (e - 24));

export class Picture {
  // The picture in `buffer`; null if it is none.
  static read(buffer) {
    const header = new DataView(buffer);
    if (buffer.byteLength < HEADER || header.getUint32(0, true) !== 0x31565053) return null;
    const word = (at) => header.getUint32(at, true);
    const picture = new Picture();
    Object.assign(picture, {
      version: word(4), iterations: word(8), width: word(12), height: word(16), wholeWidth: word(20),
      wholeHeight: word(24), layer: word(28), scale: header.getFloat32(32, true), reduced: (word(36) & 1) !== 0,
      isPlane: (word(36) & 2) !== 0, number: word(40),
    });
    if (buffer.byteLength !== HEADER + 4 * picture.width * picture.height) return null;
    picture.words = new Uint32Array(buffer, HEADER);
    return picture;
  }

  // Linear red, green and blue of the pixel number `at`, row by row.
  at(at) {
    const word = this.words[at];
    const scale = SCALES[word >>> 27] * this.scale;
    return [(word & 511) * scale, ((word >>> 9) & 511) * scale, ((word >>> 18) & 511) * scale];
  }

  // The values of the pixel that covers x and y, which run from 0 to 1; null outside.
  sample(x, y) {
    const [column, row] = [Math.floor(x * this.width), Math.floor(y * this.height)];
    if (column < 0 || row < 0 || column >= this.width || row >= this.height) return null;
    return { column, row, rgb: this.at(row * this.width + column) };
  }

  // The least and greatest values but for outliers, from a sample of pixels; `of` makes one value of a pixel.
  range(of) {
    const step = Math.max(1, Math.floor(this.words.length / 8192)) | 1;
    const values = [];
    for (let i = 0; i < this.words.length; i += step) values.push(of(this.at(i), i));
    values.sort((a, b) => a - b);
    const place = (share) => values[Math.min(values.length - 1, Math.floor(share * values.length))];
    return [place(0.01), place(0.995)];
  }
}
