// When to draw: only when something has changed, never before the last picture is finished, and for at most half of the
// time. Where drawing is slow, as without a graphics card, hands and network come first, and what moves gets coarser.
const SLOW_MS = 45;
const FAST_MS = 12;
const COARSEST = 0.6;
const LONGEST_REST_MS = 250;
const SETTLED_MS = 500;

export class Pacer {
  /** Pictures drawn so far. */
  pictures = 0;
  private wanted = false;
  private looks = false;
  private began = 0;
  private restUntil = 0;
  private sync: WebGLSync | null = null;
  private share = 1;
  private shown = 1;
  private settling = 0;

  /**
   * @param draw  draws a picture
   * @param resize  from now on pictures have this share of the pixels of a side
   */
  constructor(
    private readonly gl: WebGL2RenderingContext,
    private readonly draw: () => void,
    private readonly resize: (share: number) => void,
  ) {}

  /** Something has changed. */
  ask(): void {
    clearTimeout(this.settling);
    this.wanted = true;
    this.look();
  }

  private look(): void {
    if (this.looks) return;
    this.looks = true;
    requestAnimationFrame((now) => {
      this.looks = false;
      if (this.sync && !this.isFinished(now)) return this.look();
      if (!this.wanted) return;
      if (now < this.restUntil) return this.look();
      this.paint(now, this.share);
    });
  }

  private paint(now: number, share: number): void {
    if (share !== this.shown) this.resize(share);
    this.shown = share;
    this.wanted = false;
    this.began = now;
    this.draw();
    ++this.pictures;
    this.sync = this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.gl.flush();
    this.look();
    // Once nothing changes any more, one picture with all pixels, however long it takes.
    clearTimeout(this.settling);
    if (share < 1)
      this.settling = window.setTimeout(() => {
        if (!this.sync) this.paint(performance.now(), 1);
      }, SETTLED_MS);
  }

  private isFinished(now: number): boolean {
    if (!this.sync || this.gl.getSyncParameter(this.sync, this.gl.SYNC_STATUS) !== this.gl.SIGNALED) return false;
    this.gl.deleteSync(this.sync);
    this.sync = null;
    const took = now - this.began;
    this.restUntil = took > FAST_MS * 2 ? now + Math.min(took, LONGEST_REST_MS) : now;
    if (took > SLOW_MS) this.share = Math.max(COARSEST, this.share * 0.85);
    else if (took < FAST_MS) this.share = Math.min(1, this.share * 1.1);
    return true;
  }
}
