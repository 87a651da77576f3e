document.querySelector('layered-panorama').file = ldpPage.bytes('panorama').buffer;
