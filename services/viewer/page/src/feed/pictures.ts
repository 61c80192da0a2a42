import { OverlapSchema, type Overlap } from '@gen/corbslam/v1/overlap_pb';
import type { Features } from '@gen/corbslam/v1/items_pb';
import type { KeyframeId } from '../model/ids';
import { fullSize, type Size } from '../model/picture';
import type { Rest } from './rest';

/** What a keyframe's camera saw. */
export interface Picture {
  image: ImageBitmap;
  /** Of the picture that the keypoints are of. */
  full: Size;
}

/** A picture, or why there is none. */
export type PictureOrWhy = { picture: Picture } | { why: string };

/** One of an overlap's two keyframes. */
export interface Side {
  shown: PictureOrWhy;
  /** Its keypoints, where there is no picture. */
  features?: Features;
}

/** An overlap with what it is made of. */
export interface SeenOverlap {
  overlap: Overlap;
  query: Side;
  candidate: Side;
}

const NO_PICTURE = 'There is no picture of it: its robot sent none, or the map store has let it go.';
const FAR_LARGER = 64;

/** Asks a server for what cameras saw. */
export class Pictures {
  constructor(private readonly rest: Rest, private readonly mission: string) {}

  async of(id: KeyframeId): Promise<PictureOrWhy> {
    try {
      const { blob, scale } = await this.rest.picture(this.mission, id);
      if (blob.size === 0) return { why: NO_PICTURE };
      const image = await createImageBitmap(blob);
      return { picture: { image, full: fullSize(image, scale >= 1 && scale <= FAR_LARGER ? scale : 1) } };
    } catch (error) {
      return { why: error instanceof Error ? error.message : String(error) };
    }
  }

  async ofOverlap(number: bigint, query: KeyframeId, candidate: KeyframeId): Promise<SeenOverlap> {
    const [overlap, ...sides] = await Promise.all([
      this.rest.message(`overlaps/${number}`, this.mission, OverlapSchema), this.side(query), this.side(candidate),
    ]);
    return { overlap, query: sides[0], candidate: sides[1] };
  }

  private async side(id: KeyframeId): Promise<Side> {
    const shown = await this.of(id);
    if ('picture' in shown) return { shown };
    try {
      const { payload } = await this.rest.keyframe(this.mission, id);
      return { shown, features: payload?.features };
    } catch (error) {
      return { shown: { why: error instanceof Error ? error.message : String(error) } };
    }
  }
}
