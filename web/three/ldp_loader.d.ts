import type { Group, Matrix4 } from 'three';
import type { Head } from '../ldp.js';

/** Panoramas as objects of a three.js scene; y is up, the arc's centre is the origin. */
export class LdpLoader {
  /** The library, from r111 on. */
  constructor(THREE: object);
  load(url: string): Promise<LdpGroup>;
  parse(file: ArrayBuffer): Promise<LdpGroup>;
}

export type LdpGroup = Group & {
  userData: {
    head: Head;
    verdict: { verdict: string; expectedViewPsnrDb: number } | null;
    metadata: Record<string, string>;
    /** From the world of the source cameras into the group. */
    groupFromWorld: Matrix4;
  };
};
